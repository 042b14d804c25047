/// \file
/// TileBricks: the bricks that a tile's march goes through, as bytes. Functions that depend on the type of
/// the voxels or the edge of a brick are out of line, so the march of tiles is compiled once for all of them.
/// Private to this room.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gvx/core/index.h"
#include "gvx/render/frame/ray_state.h"
#include "gvx/render/march_pass.h"
#include "gvx/render/reference/stretch.h"

namespace gvx::render {

/// Where steps are in a brick of any type: as BrickPath says.
struct BytesPath {
  const std::byte* brick = nullptr;
  Vec3f first, per_step;
  float voxels_across = 0;
};

/// As Stretch, through bricks of any type.
struct BytesStretch : StretchSteps {
  BytesPath fine, coarse;
};

/// An object's bricks, of any voxel type and edge.
class TileBricks {
 public:
  explicit TileBricks(const ObjectView& object);

  std::uint32_t m() const { return m_; }
  const std::byte* at(BrickIndex slot) const { return bytes_ + slot.value * brick_bytes_; }
  /// Bytes of the first plane, with its border.
  std::size_t plane_bytes() const { return plane_bytes_; }

  /// Which cells of a brick of `level` can be seen (visible_cells.h).
  std::uint64_t visible_cells(const FrameView& frame, BrickIndex slot, int level) const;

  /// Adds to `state` what one ray gathers along a stretch (gather.h).
  void gather_stretch(const RayView& ray, const BytesStretch& stretch, RayState& state) const;

 private:
  const std::byte* bytes_;
  std::size_t brick_bytes_, plane_bytes_;
  std::uint32_t m_;
};

}  // namespace gvx::render
