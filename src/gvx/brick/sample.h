/// \file
/// Sampling of one plane of a brick: trilinear values, their gradient, their deviation, the nearest value.
/// Positions are in voxels from the brick's low corner, 0 to M; a position outside that by rounding is held
/// at the border.
#pragma once

#include <cstdint>
#include <type_traits>

#include "gvx/brick/brick_layout.h"
#include "gvx/core/vec.h"

namespace gvx::brick {

/// Where a coordinate falls between two texels.
template <int M>
struct TexelAxis {
  int low;
  float weight;

  /// `position` from -0.5 to M+0.5 in voxels.
  GVX_HD explicit TexelAxis(float position) {
    float texel = position + 0.5f;
    texel = texel > 0.0f ? texel : 0.0f;
    texel = texel < float(M + 1) ? texel : float(M + 1);
    low = static_cast<int>(texel);
    low = low < M ? low : M;
    weight = texel - static_cast<float>(low);
  }
};

/// The trilinear value between eight texels.
template <int M, typename Voxel>
GVX_HD inline float trilinear(const Voxel* voxels, TexelAxis<M> x, TexelAxis<M> y, TexelAxis<M> z) {
  constexpr int kRow = BrickLayout<M>::kEdge, kSlice = kRow * kRow;
  const Voxel* v = voxels + BrickLayout<M>::offset(x.low, y.low, z.low);
  const auto along_x = [&](int offset) {
    const float a = static_cast<float>(v[offset]), b = static_cast<float>(v[offset + 1]);
    return a + x.weight * (b - a);
  };
  const float c00 = along_x(0), c10 = along_x(kRow), c01 = along_x(kSlice), c11 = along_x(kSlice + kRow);
  const float c0 = c00 + y.weight * (c10 - c00), c1 = c01 + y.weight * (c11 - c01);
  return c0 + z.weight * (c1 - c0);
}

/// The stored value at a position.
template <int M, typename Voxel>
GVX_HD inline float sample(const Voxel* voxels, Vec3f position) {
  return trilinear<M>(voxels, TexelAxis<M>(position.x), TexelAxis<M>(position.y), TexelAxis<M>(position.z));
}

/// Where a coordinate falls in a uniform cubic B-spline of the texels: what four of them weigh in its value
/// and in its slope.
template <int M>
struct SplineAxis {
  int first;  ///< of the four texels
  float of_value[4], of_slope[4];

  /// `position` from -0.5 to M+0.5 in voxels.
  GVX_HD explicit SplineAxis(float position) {
    const TexelAxis<M> cell(position);
    const float t = cell.weight, s = 1 - t;
    first = cell.low - 1;
    of_value[0] = s * s * s / 6;
    of_value[1] = 2.0f / 3 - t * t * (1 - t / 2);
    of_value[2] = 2.0f / 3 - s * s * (1 - s / 2);
    of_value[3] = t * t * t / 6;
    of_slope[0] = -s * s / 2;
    of_slope[1] = t * (1.5f * t - 2);
    of_slope[2] = s * (2 - 1.5f * s);
    of_slope[3] = t * t / 2;
  }
};

/// The gradient per voxel at a position from -0.5 to M+0.5 of the uniform cubic B-spline whose coefficients
/// are the texels (Unser, "Splines: a perfect fit for signal and image processing", 1999): a smoothed
/// gradient, whose slopes go on smoothly from voxel to voxel and from brick to brick. texel(offset) is the
/// number there.
template <int M, typename Of>
GVX_HD inline Vec3f spline_gradient(Vec3f position, const Of& texel) {
  const SplineAxis<M> x(position.x), y(position.y), z(position.z);
  Vec3f gradient;
  for (int k = 0; k < 4; ++k) {
    Vec3f slice;
    for (int j = 0; j < 4; ++j) {
      const int row = BrickLayout<M>::offset(x.first, y.first + j, z.first + k);
      float value = 0, slope = 0;
      for (int i = 0; i < 4; ++i) {
        const float t = texel(row + i);
        value += x.of_value[i] * t;
        slope += x.of_slope[i] * t;
      }
      slice = slice + Vec3f(y.of_value[j] * slope, y.of_slope[j] * value, y.of_value[j] * value);
    }
    gradient = gradient + Vec3f(z.of_value[k] * slice.x, z.of_value[k] * slice.y, z.of_slope[k] * slice.z);
  }
  return gradient;
}

/// A trilinear value and its gradient per voxel in the cell between its eight texels: for less than
/// gradient(), but it jumps from cell to cell.
struct CellSample {
  float value;
  Vec3f gradient;

  GVX_HD friend CellSample operator+(const CellSample& a, const CellSample& b) {
    return {a.value + b.value, a.gradient + b.gradient};
  }
  GVX_HD friend CellSample operator-(const CellSample& a, const CellSample& b) {
    return {a.value - b.value, a.gradient - b.gradient};
  }
  GVX_HD friend CellSample operator*(float s, const CellSample& a) { return {s * a.value, s * a.gradient}; }
};

template <int M, typename Voxel>
GVX_HD inline CellSample cell_sample(const Voxel* voxels, Vec3f position) {
  constexpr int kRow = BrickLayout<M>::kEdge, kSlice = kRow * kRow;
  const TexelAxis<M> x(position.x), y(position.y), z(position.z);
  const Voxel* v = voxels + BrickLayout<M>::offset(x.low, y.low, z.low);
  const auto low = [&](int offset) { return static_cast<float>(v[offset]); };
  const auto rise = [&](int offset) { return static_cast<float>(v[offset + 1]) - low(offset); };
  const float r00 = rise(0), r10 = rise(kRow), r01 = rise(kSlice), r11 = rise(kSlice + kRow);
  const float c00 = low(0) + x.weight * r00, c10 = low(kRow) + x.weight * r10;
  const float c01 = low(kSlice) + x.weight * r01, c11 = low(kSlice + kRow) + x.weight * r11;
  const float c0 = c00 + y.weight * (c10 - c00), c1 = c01 + y.weight * (c11 - c01);
  const float r0 = r00 + y.weight * (r10 - r00), r1 = r01 + y.weight * (r11 - r01);
  const float along_y = (c10 - c00) + z.weight * ((c11 - c01) - (c10 - c00));
  return {c0 + z.weight * (c1 - c0), {r0 + z.weight * (r1 - r0), along_y, c1 - c0}};
}

/// The gradient per voxel of one plane: that of the spline; where it would take voxels that are no data, that
/// of the cell.
template <int M, typename Voxel>
GVX_HD inline Vec3f gradient(const Voxel* voxels, Vec3f position) {
  const Vec3f smooth =
      spline_gradient<M>(position, [&](int offset) { return static_cast<float>(voxels[offset]); });
  if constexpr (std::is_floating_point_v<Voxel>) {
    const float sum = smooth.x + smooth.y + smooth.z;
    if (sum != sum) return cell_sample<M>(voxels, position).gradient;
  }
  return smooth;
}

/// The standard deviation of the finest voxels that a position's value stands for, trilinear at half the
/// resolution. `deviations` are those of the plane (core/voxel.h).
template <int M>
GVX_HD inline float deviation(const std::uint8_t* deviations, Vec3f position) {
  constexpr int kHalf = M / 2, kRow = BrickLayout<kHalf, 1>::kEdge, kSlice = kRow * kRow;
  const float unit = *reinterpret_cast<const float*>(deviations);
  if (!(unit > 0.0f)) return 0.0f;
  const TexelAxis<kHalf> x(0.5f * position.x), y(0.5f * position.y), z(0.5f * position.z);
  const std::uint8_t* codes = deviations + sizeof(float) + BrickLayout<kHalf, 1>::offset(x.low, y.low, z.low);
  const auto along_x = [&](int offset) {
    const float a = deviation_of_code(codes[offset]), b = deviation_of_code(codes[offset + 1]);
    return a + x.weight * (b - a);
  };
  const float c00 = along_x(0), c10 = along_x(kRow), c01 = along_x(kSlice), c11 = along_x(kSlice + kRow);
  const float c0 = c00 + y.weight * (c10 - c00), c1 = c01 + y.weight * (c11 - c01);
  return unit * (c0 + z.weight * (c1 - c0));
}

/// The texel that a position, 0 to M, is in: its place in a plane.
template <int M>
GVX_HD inline int nearest_offset(Vec3f position) {
  const auto texel = [](float p) {
    const float held = p > 0.0f ? (p < float(M) ? p : float(M)) : 0.0f;
    const int t = static_cast<int>(held);
    return 1 + (t < M ? t : M - 1);
  };
  return BrickLayout<M>::offset(texel(position.x), texel(position.y), texel(position.z));
}

}  // namespace gvx::brick
