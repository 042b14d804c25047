/// \file
/// How the formulas read a brick in vectors (reference/sample.h does it for one ray), and samples of several
/// vectors at once. Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_SAMPLE_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_SAMPLE_SIMD_INL_H
#undef GVX_RENDER_SAMPLE_SIMD_INL_H
#else
#define GVX_RENDER_SAMPLE_SIMD_INL_H
#endif

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <hwy/highway.h>

#include "gvx/core/voxel.h"
#include "gvx/render/vectors/lanes_simd-inl.h"
#include "gvx/render/vectors/simd_targets.h"
#include "gvx/render/vectors/unroll.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

#include "gvx/render/formula/sample.inc"

/// Neighbours along x, from and behind a place, as floats.
struct Pair {
  Float low, high;
};
HWY_INLINE Pair gather_pair(const std::uint8_t* texels, Int index) {
  const Int pair = hn::GatherOffset(kInts, reinterpret_cast<const std::int32_t*>(texels), index);
  const Int byte = all_ints(0xff);
  return {hn::ConvertTo(kFloats, hn::And(pair, byte)),
          hn::ConvertTo(kFloats, hn::And(hn::ShiftRight<8>(pair), byte))};
}
HWY_INLINE Pair gather_pair(const std::uint16_t* texels, Int index) {
  const Int pair =
      hn::GatherOffset(kInts, reinterpret_cast<const std::int32_t*>(texels), hn::ShiftLeft<1>(index));
  const Int word = all_ints(0xffff);
  return {hn::ConvertTo(kFloats, hn::And(pair, word)),
          hn::ConvertTo(kFloats, hn::And(hn::ShiftRight<16>(pair), word))};
}
HWY_INLINE Pair gather_pair(const float* texels, Int index) {
  return {hn::GatherIndex(kFloats, texels, index), hn::GatherIndex(kFloats, texels + 1, index)};
}

/// The same of places that are certain to be between the centres of a brick's texels, but for rounding;
/// counted in texels from the centre of the first.
class PlacesInside {
 public:
  /// Of the edge's voxels; deviations have a border of their own.
  HWY_INLINE explicit PlacesInside(int edge, int border = kBrickBorder) {
    const int row = row_of(edge, border);
    row_ = all(static_cast<float>(row));
    slice_ = all(static_cast<float>(row * row));
    last_ = hn::Set(kBits, static_cast<std::uint32_t>(edge * (row * row + row + 1)));
    end_ = all(std::nextafter(static_cast<float>(edge + 1), 0.0f));
  }

  /// The nearest such place, of one that is farther out.
  HWY_INLINE Vec3v held(const Vec3v& texel) const {
    const Float zero = hn::Zero(kFloats);
    const auto on_axis = [&](Float x) HWY_ATTR { return hn::Min(hn::Max(x, zero), end_); };
    return {on_axis(texel.x), on_axis(texel.y), on_axis(texel.z)};
  }

  HWY_INLINE TexelPlace at(const Vec3v& texel) const {
    const Float x = hn::Floor(texel.x), y = hn::Floor(texel.y), z = hn::Floor(texel.z);
    const Int index = TexelPlace::index_of(x, y, z, row_, slice_);
    // Whatever comes, nothing outside of the brick is read.
    const Int held = hn::BitCast(kInts, hn::Min(hn::BitCast(kBits, index), last_));
    return {held, {hn::Sub(texel.x, x), hn::Sub(texel.y, y), hn::Sub(texel.z, z)}};
  }

 private:
  static constexpr hn::RebindToUnsigned<Ints> kBits{};

  Float row_, slice_, end_;
  hn::Vec<hn::RebindToUnsigned<Ints>> last_;
};

/// Texels as they are in a brick. load() and corners() are read() in two parts.
template <typename Voxel>
struct PlainTexels {
  static constexpr bool kWhole = std::is_integral_v<Voxel>, kBytes = std::is_same_v<Voxel, std::uint8_t>;
  using Raw = Corners;
  const Voxel* texels;

  /// Of a plane of a brick, or of none.
  PlainTexels(const std::byte* plane, int edge)
      : texels(plane == nullptr ? nullptr : reinterpret_cast<const Voxel*>(plane) + corner_texel(edge)) {}

  HWY_INLINE Float at(Int index) const { return gather_pair(texels, index).low; }
  HWY_INLINE Raw load(Int index, int row, int slice) const {
    const Pair p00 = gather_pair(texels, index), p10 = gather_pair(texels + row, index);
    const Pair p01 = gather_pair(texels + slice, index), p11 = gather_pair(texels + slice + row, index);
    return {{p00.low, p00.high, p10.low, p10.high, p01.low, p01.high, p11.low, p11.high}};
  }
  HWY_INLINE static Corners corners(const Raw& raw) { return raw; }
  HWY_INLINE Corners read(Int index, int row, int slice) const { return load(index, row, slice); }
};

/// Texels of bytes around a place, by x + 2 * y: that at z in the lower half of a lane, the next in the
/// upper.
struct PairsAlongZ {
  Int at[4];
};
/// Of PlainTexels: from each row the first two of the four bytes, by y + 2 * z.
struct BytesAround {
  Int row[4];
};
HWY_INLINE BytesAround load_bytes(const PlainTexels<std::uint8_t>& from, Int index, int row, int slice) {
  const auto at = [&](int offset) HWY_ATTR {
    return hn::GatherOffset(kInts, reinterpret_cast<const std::int32_t*>(from.texels + offset), index);
  };
  return {{at(0), at(row), at(slice), at(slice + row)}};
}
HWY_INLINE PairsAlongZ pairs_along_z(const BytesAround& bytes) {
  PairsAlongZ pairs;
  const Int first = all_ints(0xff), second = all_ints(0xff00);
  for (int y = 0; y < 2; ++y) {
    const Int here = bytes.row[y], next = bytes.row[y + 2];
    pairs.at[2 * y] = hn::Or(hn::And(here, first), hn::ShiftLeft<16>(hn::And(next, first)));
    pairs.at[2 * y + 1] =
        hn::Or(hn::ShiftRight<8>(hn::And(here, second)), hn::ShiftLeft<8>(hn::And(next, second)));
  }
  return pairs;
}

/// Of several vectors of places at once; place_of(k) is a TexelPlace. Each thing is done for all before the
/// next: what one waits for, the others fill.
template <typename Texels, int kVectors, typename PlaceOf>
HWY_INLINE void cell_samples_at(const Texels& texels, int edge, const PlaceOf& place_of, bool add_gradient,
                                CellSample (&samples)[kVectors]) {
  Int index[kVectors];
  Vec3v weight[kVectors];
  GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
    const TexelPlace place = place_of(k);
    index[k] = place.index;
    weight[k] = place.weight;
  }
  typename Texels::Raw raw[kVectors];
  GVX_UNROLL for (int k = 0; k < kVectors; ++k) raw[k] =
      texels.load(index[k], row_of(edge), row_of(edge) * row_of(edge));
  GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
    find_cell_sample(Texels::corners(raw[k]), weight[k], add_gradient, samples[k]);
  }
}

template <typename Texels, int kVectors>
HWY_INLINE void cell_samples(const Texels& texels, int edge, const Vec3v (&p)[kVectors], bool add_gradient,
                             CellSample (&samples)[kVectors]) {
  cell_samples_at(
      texels, edge, [&](int k) HWY_ATTR { return TexelPlace(p[k], edge); }, add_gradient, samples);
}

/// What is 16 bits wide, two in a lane: the sums of their products.
HWY_INLINE Int sum_of_products(Int a, Int b) {
#if HWY_TARGET == HWY_AVX3
  return Int{_mm512_madd_epi16(a.raw, b.raw)};
#elif HWY_TARGET == HWY_AVX2
  return Int{_mm256_madd_epi16(a.raw, b.raw)};
#elif HWY_TARGET == HWY_SSE4
  return Int{_mm_madd_epi16(a.raw, b.raw)};
#else
  const auto lower = [](Int v) HWY_ATTR { return hn::ShiftRight<16>(hn::ShiftLeft<16>(v)); };
  const auto upper = [](Int v) HWY_ATTR { return hn::ShiftRight<16>(v); };
  return hn::Add(hn::Mul(lower(a), lower(b)), hn::Mul(upper(a), upper(b)));
#endif
}

/// cell_samples at places as of PlacesInside.
template <typename Texels, bool kGradient>
class SamplesInside {
 public:
  /// Values of bytes: first along z, in whole numbers, where texels weigh so many 2^14ths. (With gradients
  /// that is no gain: these are of differences along x first.)
  static constexpr bool kInWholeNumbers = Texels::kBytes && !kGradient;
  static constexpr int kOne = 1 << 14;
  static constexpr float kUnit = kInWholeNumbers ? 1.0f / kOne : 1;  ///< what values are multiples of

  HWY_INLINE SamplesInside(const Texels& texels, int edge) : texels_(texels), edge_(edge), places_(edge) {}

  template <int kVectors>
  HWY_INLINE void find(const Vec3v (&texel)[kVectors], CellSample (&samples)[kVectors]) const {
    if constexpr (kInWholeNumbers) {
      find_bytes(texel, samples);
    } else {
      cell_samples_at(
          texels_, edge_, [&](int k) HWY_ATTR { return places_.at(texel[k]); }, kGradient, samples);
    }
  }

 private:
  static constexpr float kFirstOfWeights = 1 << 9;  // from here on the last of a float's bits is a 2^14th

  template <int kVectors>
  HWY_INLINE void find_bytes(const Vec3v (&texel)[kVectors], CellSample (&samples)[kVectors]) const {
    Int weights[kVectors];
    Float weight_x[kVectors], weight_y[kVectors];
    decltype(load_bytes(texels_, weights[0], 0, 0)) bytes[kVectors];
    GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
      const TexelPlace place = places_.at(texel[k]);
      weight_x[k] = place.weight.x;
      weight_y[k] = place.weight.y;
      const Float bits_of_z = hn::Add(place.weight.z, all(kFirstOfWeights));
      const Int upper = hn::And(hn::BitCast(kInts, bits_of_z), all_ints(2 * kOne - 1));
      weights[k] = hn::Add(hn::ShiftLeft<16>(upper), hn::Sub(all_ints(kOne), upper));
      bytes[k] = load_bytes(texels_, place.index, row_of(edge_), row_of(edge_) * row_of(edge_));
    }
    GVX_UNROLL for (int k = 0; k < kVectors; ++k) {
      const PairsAlongZ pairs = pairs_along_z(bytes[k]);
      const auto sum = [&](int i) HWY_ATTR {
        return hn::ConvertTo(kFloats, sum_of_products(pairs.at[i], weights[k]));
      };
      samples[k].value = mix(mix(sum(0), sum(1), weight_x[k]), mix(sum(2), sum(3), weight_x[k]), weight_y[k]);
    }
  }

  const Texels texels_;
  const int edge_;
  const PlacesInside places_;
};

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
