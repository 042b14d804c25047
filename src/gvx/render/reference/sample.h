/// \file
/// How the formulas read a brick for one ray: texels one by one, and deviations.
#pragma once

#include <cstdint>
#include <type_traits>

#include "gvx/brick/brick_layout.h"
#include "gvx/core/voxel.h"
#include "gvx/render/formula/one_lane.h"

namespace gvx::render::one_lane {

/// Of a plane of a brick.
template <typename Voxel>
struct PlainTexels {
  static constexpr bool kWhole = std::is_integral_v<Voxel>;
  const Voxel* texels;  // of corner_texel and behind it

  GVX_HD PlainTexels(const Voxel* plane, int edge) : texels(plane + corner_texel(edge)) {}

  GVX_HD float at(Int index) const { return static_cast<float>(texels[index]); }
  GVX_HD Corners read(Int index, int row, int slice) const {
    const Int next = index + slice;
    return {{at(index), at(index + 1), at(index + row), at(index + row + 1), at(next), at(next + 1),
             at(next + row), at(next + row + 1)}};
  }
};

template <typename Voxel>
class WindowRows<PlainTexels<Voxel>> {
 public:
  using Weights = SplineWeights;
  static constexpr float kUnit = 1;

  GVX_HD WindowRows(const PlainTexels<Voxel>& texels, int edge, Int index)
      : texels_(texels), row_(row_of(edge)), first_(index - 1 - row_ - row_ * row_) {}

  GVX_HD Four row(int j, int k) const {
    const Int first = first_ + (j + k * row_) * row_;
    return {{texels_.at(first), texels_.at(first + 1), texels_.at(first + 2), texels_.at(first + 3)}};
  }

 private:
  const PlainTexels<Voxel> texels_;
  const int row_;
  const Int first_;
};

/// The value and the gradient in a cell of a plane.
template <typename Voxel>
GVX_HD inline CellSample cell_sample(const PlainTexels<Voxel>& texels, int edge, Vec3f p, bool add_gradient) {
  const TexelPlace place(p, edge);
  CellSample sample;
  find_cell_sample(texels.read(place.index, row_of(edge), row_of(edge) * row_of(edge)), place.weight,
                   add_gradient, sample);
  return sample;
}

/// The standard deviation of the finest voxels that a position's value stands for, trilinear at half the
/// resolution. `deviations` are those of the plane (core/voxel.h).
GVX_HD inline float deviation(const std::uint8_t* deviations, int edge, Vec3f p) {
  const float unit = *reinterpret_cast<const float*>(deviations);
  if (!(unit > 0.0f)) return 0.0f;
  const TexelPlace place(0.5f * p, edge / 2, 1);
  const std::uint8_t* codes = deviations + sizeof(float) + place.index;
  const int row = row_of(edge / 2, 1), slice = row * row;
  const auto at = [&](int offset) { return deviation_of_code(codes[offset]); };
  return unit * trilinear({{at(0), at(1), at(row), at(row + 1), at(slice), at(slice + 1), at(slice + row),
                            at(slice + row + 1)}},
                          place.weight);
}

}  // namespace gvx::render::one_lane
