/// \file
/// BrickLayout: a plane of a brick is M^3 numbers and a border on every side, x fastest. Trilinear samples
/// take one voxel of the border, slopes of a cubic B-spline two; so neither ever leaves the brick.
///
///     texel    -1    0    1    2   ...   M   M+1  M+2
///             [  border ][v 0][v 1] ... [vM-1][border  ]
///     position            0    1    2 ...     M            a voxel is one wide; its centre is at .5
#pragma once

#include <cstddef>
#include <cstdint>

#include "gvx/core/macros.h"
#include "gvx/core/voxel.h"

namespace gvx::brick {

template <int M, int kBorder = kBrickBorder>
struct BrickLayout {
  static constexpr int kVoxels = M;
  static constexpr int kEdge = M + 2 * kBorder;
  static constexpr std::size_t kTexels = plane_texels(M, kBorder);

  /// The texel's place in the brick; coordinates from 1 - kBorder to M + kBorder.
  GVX_HD static constexpr int offset(int x, int y, int z) {
    constexpr int kFirst = kBorder - 1;
    return x + kFirst + kEdge * (y + kFirst + kEdge * (z + kFirst));
  }
};

}  // namespace gvx::brick
