/// \file
/// Gradients of a brick in vectors: brick/sample.h once more, the same names mean the same.
/// Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_GRADIENT_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_GRADIENT_SIMD_INL_H
#undef GVX_RENDER_GRADIENT_SIMD_INL_H
#else
#define GVX_RENDER_GRADIENT_SIMD_INL_H
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "gvx/render/quads_simd-inl.h"
#include "gvx/render/sample_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// Along one axis of a voxel, at a place from 0 to 1 in it: what its texel and its neighbours weigh in the
/// value and in the difference of half a voxel to either side.
struct ThreeTexels {
  Float of_value[3], of_difference[3];
  Float off_centre;
  Mask behind;  // the centre

  HWY_INLINE explicit ThreeTexels(Float in_voxel) {
    const Float zero = hn::Zero(kFloats), one = all(1);
    const Float from_centre = hn::Sub(in_voxel, all(0.5f));
    of_value[0] = hn::Max(hn::Neg(from_centre), zero);
    of_value[1] = hn::Sub(one, hn::Abs(from_centre));
    of_value[2] = hn::Max(from_centre, zero);
    off_centre = hn::Abs(from_centre);
    behind = hn::Ge(from_centre, zero);
    of_difference[0] = hn::Sub(in_voxel, one);
    of_difference[1] = hn::Sub(one, hn::Add(in_voxel, in_voxel));
    of_difference[2] = in_voxel;
  }
};

struct Triple {
  Float texel[3];
};
HWY_INLINE Triple gather_triple(const std::uint8_t* texels, Int index) {
  // The fourth byte may be the first behind the plane, even behind the brick (BrickPool leaves room there).
  const Int four = hn::GatherOffset(kInts, reinterpret_cast<const std::int32_t*>(texels), index);
  const Int byte = all_ints(0xff);
  return {{hn::ConvertTo(kFloats, hn::And(four, byte)),
           hn::ConvertTo(kFloats, hn::And(hn::ShiftRight<8>(four), byte)),
           hn::ConvertTo(kFloats, hn::And(hn::ShiftRight<16>(four), byte))}};
}
template <typename Voxel>
HWY_INLINE Triple gather_triple(const Voxel* texels, Int index) {
  const Pair first = gather_pair(texels, index), last = gather_pair(texels + 1, index);
  return {{first.low, first.high, last.high}};
}

HWY_INLINE Float weighted(const Float (&weight)[3], Float a, Float b, Float c) {
  return hn::MulAdd(weight[0], a, hn::MulAdd(weight[1], b, hn::Mul(weight[2], c)));
}
/// The value between three texels. Where these may be no data, that which weighs nothing is not looked at.
template <bool kLacks>
HWY_INLINE Float value_of(const ThreeTexels& at, Float a, Float b, Float c) {
  if constexpr (!kLacks) return weighted(at.of_value, a, b, c);
  return hn::MulAdd(at.of_value[1], b, hn::Mul(at.off_centre, hn::IfThenElse(at.behind, c, a)));
}

/// The texels of Around::rows, from the first on.
template <typename Voxel>
HWY_INLINE void read_rows(const PlainTexels<Voxel>& texels, int edge, Int index, Triple (&rows)[9]) {
  const int row = edge + 2, slice = row * row;
  for (int i = 0; i < 9; ++i) {
    rows[i] = gather_triple(texels.texels + i % 3 * row + i / 3 * slice, index);
  }
}
HWY_INLINE void read_rows(const QuadTexels& texels, int edge, Int index, Triple (&rows)[9]) {
  const int row = edge + 2, slice = row * row;
  alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
  store_offsets(hn::ShiftLeft<2>(index), offsets);
  const auto* quads = reinterpret_cast<const std::byte*>(texels.quads);
  constexpr auto kQuad = static_cast<int>(sizeof(std::uint32_t));
  Int low[4], next_y[4], next_z[4], next[4];
  load_rows(quads, offsets, low);
  load_rows(quads + kQuad * row, offsets, next_y);
  load_rows(quads + kQuad * slice, offsets, next_z);
  load_rows(quads + kQuad * (slice + row), offsets, next);
  for (int x = 0; x < 3; ++x) {
    rows[0].texel[x] = QuadTexels::byte<0>(low[x]);
    rows[1].texel[x] = QuadTexels::byte<8>(low[x]);
    rows[2].texel[x] = QuadTexels::byte<8>(next_y[x]);
    rows[3].texel[x] = QuadTexels::byte<16>(low[x]);
    rows[4].texel[x] = QuadTexels::byte<24>(low[x]);
    rows[5].texel[x] = QuadTexels::byte<24>(next_y[x]);
    rows[6].texel[x] = QuadTexels::byte<16>(next_z[x]);
    rows[7].texel[x] = QuadTexels::byte<24>(next_z[x]);
    rows[8].texel[x] = QuadTexels::byte<24>(next[x]);
  }
}

/// The 3 x 3 x 3 texels around a voxel, in rows along x: those of y j and z k at j + 3 k. All that the
/// gradients of a voxel need.
struct Around {
  Vec3v first;  ///< the low corner of the voxel
  Triple rows[9];

  template <typename Texels>
  HWY_INLINE void read(const Texels& texels, int edge, const Vec3v& p) {
    first = {first_of(p.x, edge), first_of(p.y, edge), first_of(p.z, edge)};
    read_rows(texels, edge, TexelPlace::index_of(first.x, first.y, first.z, edge), rows);
  }

  /// brick::gradient at a place in this voxel.
  template <bool kLacks>
  HWY_INLINE Vec3v gradient(const Vec3v& p) const {
    const ThreeTexels x(hn::Sub(p.x, first.x)), y(hn::Sub(p.y, first.y)), z(hn::Sub(p.z, first.z));
    Float along_x[3], along_y[3], value[3];
    for (int k = 0; k < 3; ++k) {
      Float row_value[3], row_difference[3];
      for (int j = 0; j < 3; ++j) {
        const auto& t = rows[j + 3 * k].texel;
        row_value[j] = value_of<kLacks>(x, t[0], t[1], t[2]);
        row_difference[j] = weighted(x.of_difference, t[0], t[1], t[2]);
      }
      value[k] = value_of<kLacks>(y, row_value[0], row_value[1], row_value[2]);
      along_x[k] = value_of<kLacks>(y, row_difference[0], row_difference[1], row_difference[2]);
      along_y[k] = weighted(y.of_difference, row_value[0], row_value[1], row_value[2]);
    }
    return {value_of<kLacks>(z, along_x[0], along_x[1], along_x[2]),
            value_of<kLacks>(z, along_y[0], along_y[1], along_y[2]),
            weighted(z.of_difference, value[0], value[1], value[2])};
  }

 private:
  HWY_INLINE static Float first_of(Float position, int edge) {
    const Float last = all(static_cast<float>(edge - 1));
    return hn::Min(hn::Floor(hn::Max(position, hn::Zero(kFloats))), last);
  }
};

/// A place in a brick, if it was outside of it by rounding.
HWY_INLINE Vec3v held(const Vec3v& p, int edge) {
  const Float zero = hn::Zero(kFloats), last = all(static_cast<float>(edge));
  const auto on_axis = [&](Float x) HWY_ATTR { return hn::Min(hn::Max(x, zero), last); };
  return {on_axis(p.x), on_axis(p.y), on_axis(p.z)};
}

/// brick::gradient.
template <typename Texels>
HWY_INLINE Vec3v gradient(const Texels& texels, int edge, const Vec3v& p) {
  Around around;
  around.read(texels, edge, p);
  return around.template gradient<!Texels::kWhole>(held(p, edge));
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
