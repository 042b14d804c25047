/// \file
/// Sampling of one plane of a brick: trilinear values, their gradient, their deviation, the nearest value.
/// Positions are in voxels from the brick's low corner, 0 to M; a position outside that by rounding is held
/// at the border.
#pragma once

#include <cstdint>

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

/// The gradient per voxel by central differences of half a voxel, at a position from 0 to M: continuous, and
/// the same on both sides of a face.
template <int M, typename Voxel>
GVX_HD inline Vec3f gradient(const Voxel* voxels, Vec3f position) {
  const TexelAxis<M> at[3] = {TexelAxis<M>(position.x), TexelAxis<M>(position.y), TexelAxis<M>(position.z)};
  Vec3f gradient;
  for (int axis = 0; axis < 3; ++axis) {
    TexelAxis<M> after[3] = {at[0], at[1], at[2]}, before[3] = {at[0], at[1], at[2]};
    after[axis] = TexelAxis<M>(position[axis] + 0.5f);
    before[axis] = TexelAxis<M>(position[axis] - 0.5f);
    gradient[axis] = trilinear<M>(voxels, after[0], after[1], after[2]) -
                     trilinear<M>(voxels, before[0], before[1], before[2]);
  }
  return gradient;
}

/// A trilinear value and its gradient per voxel in the cell between its eight texels: for less than
/// gradient(), but it jumps at texels.
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

/// The standard deviation of the finest voxels that a position's value stands for, trilinear at half the
/// resolution. `deviations` are those of the plane (core/voxel.h).
template <int M>
GVX_HD inline float deviation(const std::uint8_t* deviations, Vec3f position) {
  constexpr int kHalf = M / 2, kRow = BrickLayout<kHalf>::kEdge, kSlice = kRow * kRow;
  const float unit = *reinterpret_cast<const float*>(deviations);
  if (!(unit > 0.0f)) return 0.0f;
  const TexelAxis<kHalf> x(0.5f * position.x), y(0.5f * position.y), z(0.5f * position.z);
  const std::uint8_t* codes = deviations + sizeof(float) + BrickLayout<kHalf>::offset(x.low, y.low, z.low);
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
