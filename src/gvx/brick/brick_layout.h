/// \file
/// BrickLayout: a plane of a brick is M^3 numbers and a border of one on every side, x fastest. Trilinear
/// samples and central differences of half a voxel therefore never leave the brick.
///
///     texel     0    1    2   ...   M   M+1
///             [bord][v 0][v 1] ... [vM-1][bord]
///     position       0    1    2 ...     M            a voxel is one wide; its centre is at .5
#pragma once

#include <cstddef>
#include <cstdint>

#include "gvx/core/macros.h"
#include "gvx/core/voxel.h"

namespace gvx::brick {

template <int M>
struct BrickLayout {
  static constexpr int kVoxels = M;
  static constexpr int kEdge = M + 2;
  static constexpr std::size_t kTexels = plane_texels(M);

  /// The texel's place in the brick; coordinates from 0 to M+1.
  GVX_HD static constexpr int offset(int x, int y, int z) { return x + kEdge * (y + kEdge * z); }
};

}  // namespace gvx::brick
