/// \file
/// What producers of values share: how a value becomes a voxel, which voxels a node has, and what bounds it.
#pragma once

#include <cmath>
#include <limits>
#include <type_traits>

#include "gvx/core/macros.h"
#include "gvx/produce/field.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

/// (value - offset) / scale, rounded and held to what the type holds. Never changes the order of two values.
struct StoredValue {
  double scale = 1, offset = 0;

  explicit StoredValue(const TreeDescription& tree) : scale(tree.scale), offset(tree.offset) {}

  template <typename Voxel>
  GVX_HD Voxel of(double value) const {
    const double stored = (value - offset) / scale;
    if constexpr (std::is_same_v<Voxel, float>) {
      return static_cast<float>(stored);
    } else {
      // What is no number is the least.
      constexpr double kMost = std::numeric_limits<Voxel>::max();
      return static_cast<Voxel>(std::fmin(std::fmax(std::floor(stored + 0.5), 0.0), kMost));
    }
  }
};

/// What a tree stores for the ends of a range of values.
inline ValueRange stored_range(ValueRange values, const TreeDescription& tree) {
  return with_voxel_type(tree.format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    const StoredValue stored(tree);
    return ValueRange{static_cast<float>(stored.of<Voxel>(values.minimum)),
                      static_cast<float>(stored.of<Voxel>(values.maximum))};
  });
}

/// What a producer of a tree finds bounds of for a node: it with a rim of n voxels; and its coarsest voxels,
/// which are those of the level above, blended in.
struct NodeBounds {
  Box3d box;
  double coarsest_spacing;

  GVX_HD NodeBounds(const NodeKey& key, std::uint32_t n, std::uint32_t m) {
    const double across = nodes_across(static_cast<int>(n), key.level);
    coarsest_spacing = n / (across * m);
    const Vec3d low = corner(key) / across;
    box = {low - Vec3d(coarsest_spacing), low + Vec3d(1 / across + coarsest_spacing)};
  }
};

/// The voxels of a node's brick, border and all.
inline VoxelBlock block_of(const NodeKey& key, std::uint32_t n, std::uint32_t m) {
  const double edge = m, voxel = 1 / (nodes_across(static_cast<int>(n), key.level) * edge);
  return {voxel * (edge * corner(key) - Vec3d(kBrickBorder - 0.5)), voxel, m + 2 * kBrickBorder};
}

}  // namespace gvx::produce
