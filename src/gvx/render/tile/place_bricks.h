/// \file
/// PlaceBricks: from where a walk of the tree ended to the bricks that a batch of rays is to go through
/// there. Private to this room.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "gvx/brick/cell_masks.h"
#include "gvx/render/reference/tree_walk.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/tile/tile_bricks.h"
#include "gvx/render/tile/tile_rays.h"
#include "gvx/render/tile/visible_cells.h"
#include "gvx/render/vectors/vectors.h"

namespace gvx::render {

template <int N>
class PlaceBricks {
 public:
  PlaceBricks(const FrameView& frame, const TileBricks& bricks, brick::CellMaskView cells, Vectors vectors)
      : frame_(frame), bricks_(bricks), cells_(cells), vectors_(vectors) {}

  /// Makes the batch ready for a place's brick; false where nothing of that can be seen.
  bool prepare(const Place& place, int level, StretchesWanted& wanted, StretchBatch& batch) const {
    batch.units = frame_.units_per_tick * static_cast<float>(wanted.stride);
    batch.level = wanted.step_level;
    batch.blended = place.blended;
    wanted.fine = path_of(place, place.slot, place.brick_level, batch.fine);
    batch.fine.deviates = place.deviates(frame_, level);
    batch.fine.gradient_scale = frame_.gradient_scale[wanted.step_level];
    if (place.blended) {
      wanted.coarse = path_of(place, place.parent_slot, place.level - 1, batch.coarse);
      batch.coarse.deviates = true;
      batch.coarse.gradient_scale = frame_.gradient_scale[wanted.step_level - 1];
    }
    batch.cells = cells_of(place);
    const bool pays =
        vectors_ == Vectors::composite_post || (vectors_ == Vectors::composite && place.blended);
    if (batch.cells != 0 && pays) prefetch(batch.fine.brick);
    return batch.cells != 0;
  }

 private:
  /// Has the processor fetch a brick, while its rays are gathered.
  void prefetch([[maybe_unused]] const std::byte* brick) const {
#if defined(__GNUC__)
    // No more than half of what the nearest cache holds.
    constexpr std::size_t kMost = 16384;
    const std::size_t bytes = std::min(bricks_.plane_bytes(), kMost);
    for (std::size_t byte = 0; byte < bytes; byte += 64) __builtin_prefetch(brick + byte);
#endif
  }

  /// Those of a place's cells in which something can be seen; all where that is not known.
  std::uint64_t cells_of(const Place& place) const {
    constexpr std::uint64_t kAll = ~std::uint64_t(0);
    const scene::TransferView& function = frame_.visibility.functions[0];
    const bool post = frame_.classification == scene::Classification::post;
    if (vectors_ != Vectors::composite && !(post && frame_.step_colors != nullptr)) return kAll;
    // What is blended of values that cannot be seen may be between them.
    if (place.blended && post && !function.hides_lowest_only()) return kAll;
    const std::uint64_t cells = cells_of(place.slot, place.brick_level);
    if (!place.blended || cells == kAll) return cells;
    const Vec3d child = frame_.bundle.levels[place.level].child(place.cell, N);
    const int digit[3] = {static_cast<int>(child.x), static_cast<int>(child.y), static_cast<int>(child.z)};
    return cells | cells_of_child<N>(cells_of(place.parent_slot, place.level - 1), digit);
  }
  std::uint64_t cells_of(BrickIndex slot, int level) const {
    return cells_.of(slot, [&] { return bricks_.visible_cells(frame_, slot, level); });
  }

  BrickPlace path_of(const Place& place, BrickIndex slot, int level, StretchBatch::Path& path) const {
    path.brick = bricks_.at(slot);
    const BrickCorner<N> at(frame_, place, level);
    path.voxels_across = static_cast<float>(at.across * bricks_.m());
    const bool is_parent = place.blended && level != place.level;
    const Vec3d child = is_parent ? frame_.bundle.levels[place.level].child(place.cell, N) : Vec3d();
    for (int axis = 1; axis < 3; ++axis) {
      const auto digit = static_cast<std::uint32_t>(child[axis]);
      const std::uint32_t m = bricks_.m();
      path.first_row[axis - 1] = digit * m / N;
      path.last_row[axis - 1] = is_parent ? ((digit + 1) * m + N - 1) / N : m;
    }
    return {at.across, at.corner};
  }

  const FrameView& frame_;
  const TileBricks& bricks_;
  const brick::CellMaskView cells_;
  const Vectors vectors_;
};

}  // namespace gvx::render
