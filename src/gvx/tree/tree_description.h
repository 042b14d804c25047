/// \file
/// TreeDescription: the shape of a volume's tree, its voxels, and its place in the world.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/ray.h"
#include "gvx/core/volume_description.h"

namespace gvx::tree {

/// *Tree space* is the cube [0, 1]^3 of the root.
struct TreeDescription : VolumeDescription {
  std::uint32_t n = 2;          ///< children along an axis of a node: 2 or 3
  std::uint32_t m = 16;         ///< voxels along an axis of a brick, border not counted: 8, 16 or 32
  std::uint32_t max_level = 0;  ///< level of the finest nodes; the root has level 0
  Affine3 tree_to_world;
  Box3d extent{{0, 0, 0}, {1, 1, 1}};  ///< the part of tree space that holds the volume
  /// The part of the extent that is not empty, if it is known. Default cameras show this part.
  std::optional<Box3d> bounds = {};
  /// Places around what is not empty, closer than `bounds`, if they are known. Default cameras show them.
  std::vector<Vec3d> outline;
  float beyond_ranges = 0;  ///< how far voxels that are made may lie outside of `ranges`
  /// In which the source shows its channels: red, green, blue from 0 to 1. One a channel, or none.
  std::vector<std::optional<Vec3f>> channel_colors;
  /// describe() returns exact ranges. If not, the engine looks for finest bricks that are constant after all.
  bool exact_ranges = false;
  /// There are no voxels: the elements are those of a surface, whose bricks have m cells along an edge.
  bool surface = false;
  std::uint64_t bricks = 0;  ///< the most bricks that there can be, or 0 if unknown: limits the memory

  std::size_t brick_bytes() const { return gvx::brick_bytes(format, m); }
  /// The stored values that voxels of a channel may have.
  ValueRange range_of_voxels(std::uint32_t channel) const {
    const ValueRange range = ranges.channel[channel];
    return {range.minimum - beyond_ranges, range.maximum + beyond_ranges};
  }
};

}  // namespace gvx::tree
