/// \file
/// PlaceBricks: from where a walk of the tree ended to the bricks that a batch of rays is to go through
/// there. Private to this room.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "gvx/render/stretch_batch.h"
#include "gvx/render/tile_rays.h"
#include "gvx/render/tree_walk.h"
#include "gvx/render/vectors.h"
#include "gvx/render/visible_cells.h"

namespace gvx::render {

template <typename Voxel, int N, int M>
class PlaceBricks {
 public:
  PlaceBricks(const PassView<Voxel, N, M>& view, Vectors vectors) : view_(view), vectors_(vectors) {}

  /// Makes the batch ready for a place's brick; false where nothing of that can be seen.
  bool prepare(const Place& place, int level, StretchesWanted& wanted, StretchBatch& batch) const {
    const FrameView& frame = view_.frame;
    batch.units = frame.units_per_tick * static_cast<float>(wanted.stride);
    batch.level = wanted.step_level;
    batch.blended = place.blended;
    wanted.fine = path_of(place, place.slot, place.brick_level, batch.fine);
    // Far coarser than wanted, deviations are of more than a step can tell apart: they would show fog.
    batch.fine.deviates = place.brick_level < frame.max_level && place.brick_level == level;
    batch.fine.gradient_scale = frame.gradient_scale[wanted.step_level];
    if (place.blended) {
      wanted.coarse = path_of(place, place.parent_slot, place.level - 1, batch.coarse);
      batch.coarse.deviates = true;
      batch.coarse.gradient_scale = frame.gradient_scale[wanted.step_level - 1];
    }
    batch.cells = cells_of(place);
    const bool pays =
        vectors_ == Vectors::composite_post || (vectors_ == Vectors::composite && place.blended);
    if (batch.cells != 0 && pays) prefetch(batch.fine.brick);
    return batch.cells != 0;
  }

 private:
  /// Has the processor fetch a brick, while its rays are gathered.
  static void prefetch([[maybe_unused]] const std::byte* brick) {
#if defined(__GNUC__)
    // No more than half of what the nearest cache holds.
    constexpr std::size_t kMost = 16384, kBytes = std::min(plane_texels(M) * sizeof(Voxel), kMost);
    for (std::size_t byte = 0; byte < kBytes; byte += 64) __builtin_prefetch(brick + byte);
#endif
  }

  /// Those of a place's cells in which something can be seen; all where that is not known.
  std::uint64_t cells_of(const Place& place) const {
    constexpr std::uint64_t kAll = ~std::uint64_t(0);
    const scene::TransferView& function = view_.frame.visibility.functions[0];
    const bool post = view_.frame.classification == scene::Classification::post;
    if (vectors_ != Vectors::composite && !(post && view_.frame.step_colors != nullptr)) return kAll;
    // What is blended of values that cannot be seen may be between them.
    if (place.blended && post && !function.hides_lowest_only()) return kAll;
    const std::uint64_t cells = cells_of(place.slot, place.brick_level);
    if (!place.blended || cells == kAll) return cells;
    const Vec3d child = view_.frame.levels[place.level].child(place.cell, N);
    const int digit[3] = {static_cast<int>(child.x), static_cast<int>(child.y), static_cast<int>(child.z)};
    return cells | cells_of_child<N>(cells_of(place.parent_slot, place.level - 1), digit);
  }
  std::uint64_t cells_of(BrickIndex slot, int level) const {
    return view_.cells.of(slot, [&] {
      const scene::TransferView& function = view_.frame.visibility.functions[0];
      // A pre-integrated step may go from one cell to another, and through all that is between their values.
      const bool post = view_.frame.classification == scene::Classification::post;
      const auto brick = view_.bricks.brick(slot);
      return visible_cells<M>(
          brick.voxels, post || level == view_.frame.max_level ? nullptr : brick.deviations(0),
          [&](ValueRange values, float deviation) {
            return post ? function.transparent(values) : function.below_visible(values, deviation);
          });
    });
  }

  BrickPlace path_of(const Place& place, BrickIndex slot, int level, StretchBatch::Path& path) const {
    path.brick = reinterpret_cast<const std::byte*>(view_.bricks.brick(slot).voxels);
    const BrickCorner<N> at(view_.frame, place, level);
    path.voxels_across = static_cast<float>(at.across * M);
    const bool is_parent = place.blended && level != place.level;
    const Vec3d child = is_parent ? view_.frame.levels[place.level].child(place.cell, N) : Vec3d();
    for (int axis = 1; axis < 3; ++axis) {
      const auto digit = static_cast<std::uint32_t>(child[axis]);
      path.first_row[axis - 1] = digit * M / N;
      path.last_row[axis - 1] = is_parent ? ((digit + 1) * M + N - 1) / N : M;
    }
    return {at.across, at.corner};
  }

  const PassView<Voxel, N, M>& view_;
  const Vectors vectors_;
};

}  // namespace gvx::render
