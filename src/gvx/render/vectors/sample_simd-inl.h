/// \file
/// Sampling of a brick in vectors: brick/sample.h once more, the same names mean the same.
/// Compiled once for each instruction set.

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
#include <cstring>
#include <type_traits>

#include <hwy/highway.h>

#include "gvx/core/voxel.h"
#include "gvx/render/vectors/unroll.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Ints = hn::RebindToSigned<Floats>;
using Float = hn::Vec<Floats>;
using Int = hn::Vec<Ints>;
using Mask = hn::Mask<Floats>;
constexpr Floats kFloats;
constexpr Ints kInts;

HWY_INLINE Float all(float value) {
  return hn::Set(kFloats, value);
}
HWY_INLINE Int all_ints(std::int32_t value) {
  return hn::Set(kInts, value);
}
HWY_INLINE bool none(Mask mask) {
  return hn::AllFalse(kFloats, mask);
}

/// May voxels be no data? That is NaN, with which the least and greatest of two numbers depend on their
/// order, and on the instruction set: it is to be told by comparisons.
template <typename Voxel>
constexpr bool kMayLack = std::is_floating_point_v<Voxel>;
HWY_INLINE Mask is_no_data(Float value) {
  return hn::IsNaN(value);  // Ne is ordered on x86, and false
}

struct Vec3v {
  Float x, y, z;
};
HWY_INLINE Float dot(const Vec3v& a, const Vec3v& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Vec3v along(const Vec3v& first, const Vec3v& per_step, Float i) {
  return {hn::MulAdd(i, per_step.x, first.x), hn::MulAdd(i, per_step.y, first.y),
          hn::MulAdd(i, per_step.z, first.z)};
}
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

/// Floats that are whole numbers from 0 to 2^22, as integers. (A conversion would mind all the others, too.)
/// What is no number must be held before: Max(it, 0) is 0 on x86.
HWY_INLINE Int whole(Float value) {
  constexpr float kFirst = 1 << 23;  // from here on floats' last bit is 1
  constexpr std::int32_t kBits = 0x4b000000;
  return hn::Sub(hn::BitCast(kInts, hn::Add(value, all(kFirst))), all_ints(kBits));
}

/// Floats that integers hold, without their fractions. (A conversion would mind all the others, too.)
HWY_INLINE Int truncated(Float value) {
#if HWY_TARGET == HWY_AVX2
  return Int{_mm256_cvttps_epi32(value.raw)};
#elif HWY_TARGET == HWY_AVX3
  return Int{_mm512_cvttps_epi32(value.raw)};
#else
  return hn::ConvertTo(kInts, value);
#endif
}

/// Texels in a row of a brick's plane, border included.
constexpr int row_of(int edge, int border = kBrickBorder) {
  return edge + 2 * border;
}
/// The texel at the low corner of what trilinear samples take, from which texels are counted here: the plane
/// begins with the rest of its border.
constexpr std::size_t corner_texel(int edge) {
  const auto row = static_cast<std::size_t>(row_of(edge));
  return (kBrickBorder - 1) * (1 + row + row * row);
}

/// Stores whole numbers that are to be read one by one, from memory: to take a vector apart takes longer.
HWY_INLINE void store_offsets(Int values, std::int32_t* offsets) {
  hn::Store(values, kInts, offsets);
#if defined(__GNUC__)
  __asm__("" : "+m"(*reinterpret_cast<std::int32_t(*)[hn::MaxLanes(kInts)]>(offsets)));
#endif
}

/// brick::TexelAxis of three axes.
struct TexelPlace {
  Int index;  ///< of the texel nearest to the low corner
  Vec3v weight;

  HWY_INLINE TexelPlace(const Vec3v& p, int edge) {
    const Float x = held(p.x, edge), y = held(p.y, edge), z = held(p.z, edge);
    const Float low_x = low(x, edge), low_y = low(y, edge), low_z = low(z, edge);
    weight = {hn::Sub(x, low_x), hn::Sub(y, low_y), hn::Sub(z, low_z)};
    index = index_of(low_x, low_y, low_z, edge);
  }
  HWY_INLINE TexelPlace(Int at, const Vec3v& weights) : index(at), weight(weights) {}

  /// Floats hold it exactly: a brick of 32 has 46656 texels.
  HWY_INLINE static Int index_of(Float x, Float y, Float z, Float row, Float slice) {
    return whole(hn::MulAdd(z, slice, hn::MulAdd(y, row, x)));
  }
  HWY_INLINE static Int index_of(Float x, Float y, Float z, int edge) {
    const auto row = static_cast<float>(row_of(edge));
    return index_of(x, y, z, all(row), all(row * row));
  }

 private:
  HWY_INLINE static Float held(Float position, int edge) {
    return hn::Min(hn::Max(hn::Add(position, all(0.5f)), hn::Zero(kFloats)),
                   all(static_cast<float>(edge + 1)));
  }
  HWY_INLINE static Float low(Float texel, int edge) {
    return hn::Min(hn::Floor(texel), all(static_cast<float>(edge)));
  }
};

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

#if HWY_TARGET != HWY_SCALAR
/// Turns four vectors of 4 x 4 numbers in each block of 128 bits: rows for columns.
HWY_INLINE void turn(const Int rows[4], Int columns[4]) {
  const hn::RepartitionToWide<Ints> pairs;
  const auto pair = [&](Int v) HWY_ATTR { return hn::BitCast(pairs, v); };
  const Int a = hn::InterleaveLower(kInts, rows[0], rows[1]),
            b = hn::InterleaveUpper(kInts, rows[0], rows[1]);
  const Int c = hn::InterleaveLower(kInts, rows[2], rows[3]),
            d = hn::InterleaveUpper(kInts, rows[2], rows[3]);
  columns[0] = hn::BitCast(kInts, hn::InterleaveLower(pairs, pair(a), pair(c)));
  columns[1] = hn::BitCast(kInts, hn::InterleaveUpper(pairs, pair(a), pair(c)));
  columns[2] = hn::BitCast(kInts, hn::InterleaveLower(pairs, pair(b), pair(d)));
  columns[3] = hn::BitCast(kInts, hn::InterleaveUpper(pairs, pair(b), pair(d)));
}
#endif

/// Four 32-bit numbers of each lane, table + offset in bytes onwards: out[i] has the i-th of every lane. Rows
/// are loaded whole and turned, which is several times as fast as gathering.
HWY_INLINE void load_rows(const std::byte* table, const std::int32_t* offsets, Int out[4]) {
#if HWY_TARGET == HWY_SCALAR
  std::int32_t row[4];  // of 16-bit numbers, too, which need not be aligned
  std::memcpy(row, table + offsets[0], sizeof(row));
  for (std::size_t i = 0; i < 4; ++i) out[i] = hn::Set(kInts, row[i]);
#else
  const auto row = [&](std::size_t lane) HWY_ATTR {
    const auto* numbers = reinterpret_cast<const std::int32_t*>(table + offsets[lane]);
    return hn::LoadU(hn::Full128<std::int32_t>(), numbers);
  };
  Int part[4];
  for (std::size_t i = 0; i < 4; ++i) {
#if HWY_MAX_BYTES == 16
    part[i] = row(i);
#elif HWY_MAX_BYTES == 32
    part[i] = hn::Combine(kInts, row(4 + i), row(i));
#elif HWY_TARGET == HWY_AVX3
    // Loaded into place: to put halves together takes 1.3 times as long (Zen 4).
    const auto raw = [&](std::size_t lane) HWY_ATTR { return row(lane).raw; };
    __m512i four = _mm512_castsi128_si512(raw(i));
    four = _mm512_mask_broadcast_i32x4(four, 0x00f0, raw(4 + i));
    four = _mm512_mask_broadcast_i32x4(four, 0x0f00, raw(8 + i));
    part[i] = Int{_mm512_mask_broadcast_i32x4(four, 0xf000, raw(12 + i))};
#else
    const hn::Half<Ints> half;
    part[i] =
        hn::Combine(kInts, hn::Combine(half, row(12 + i), row(8 + i)), hn::Combine(half, row(4 + i), row(i)));
#endif
  }
  turn(part, out);
#endif
}

/// The reverse: writes all lanes' numbers to their rows, the first lane's last, so that of two lanes with the
/// same row the first counts.
HWY_INLINE void store_rows(const Int numbers[4], const std::int32_t* offsets, std::byte* table) {
#if HWY_TARGET == HWY_SCALAR
  auto* row = reinterpret_cast<std::int32_t*>(table + offsets[0]);
  for (std::size_t i = 0; i < 4; ++i) row[i] = hn::GetLane(numbers[i]);
#else
  const auto put = [&](auto row, std::size_t lane) HWY_ATTR {
    hn::StoreU(row, hn::Full128<std::int32_t>(), reinterpret_cast<std::int32_t*>(table + offsets[lane]));
  };
  Int part[4];
  turn(numbers, part);
  [[maybe_unused]] const auto put_blocks = [&](std::size_t block, auto of) HWY_ATTR {
    for (std::size_t i = 4; i-- > 0;) put(of(part[i]), 4 * block + i);
  };
#if HWY_MAX_BYTES == 16
  put_blocks(0, [](Int v) HWY_ATTR { return v; });
#elif HWY_MAX_BYTES == 32
  const hn::Full128<std::int32_t> half;
  put_blocks(1, [&](Int v) HWY_ATTR { return hn::UpperHalf(half, v); });
  put_blocks(0, [&](Int v) HWY_ATTR { return hn::LowerHalf(half, v); });
#else
  const hn::Half<Ints> half;
  const hn::Half<hn::Half<Ints>> quarter;
  put_blocks(3, [&](Int v) HWY_ATTR { return hn::UpperHalf(quarter, hn::UpperHalf(half, v)); });
  put_blocks(2, [&](Int v) HWY_ATTR { return hn::LowerHalf(quarter, hn::UpperHalf(half, v)); });
  put_blocks(1, [&](Int v) HWY_ATTR { return hn::UpperHalf(quarter, hn::LowerHalf(half, v)); });
  put_blocks(0, [&](Int v) HWY_ATTR { return hn::LowerHalf(quarter, hn::LowerHalf(half, v)); });
#endif
#endif
}

HWY_INLINE Float mix(Float a, Float b, Float weight) {
  return hn::MulAdd(weight, hn::Sub(b, a), a);
}
/// render::blended: where voxels may be no data, a coarse one without a share counts for nothing.
template <bool kLacks>
HWY_INLINE Float blended(Float fine, Float coarse, Float share) {
  const Float both = mix(fine, coarse, share);
  if constexpr (!kLacks) return both;
  return hn::IfThenElse(hn::Gt(share, hn::Zero(kFloats)), both, fine);
}
template <bool kLacks>
HWY_INLINE Vec3v blended(const Vec3v& fine, const Vec3v& coarse, Float share) {
  return {blended<kLacks>(fine.x, coarse.x, share), blended<kLacks>(fine.y, coarse.y, share),
          blended<kLacks>(fine.z, coarse.z, share)};
}
/// Of gradients, render::gradient_or_none.
template <bool kLacks>
HWY_INLINE Vec3v or_none(const Vec3v& gradient) {
  if constexpr (!kLacks) return gradient;
  const Float sum = hn::Add(hn::Add(gradient.x, gradient.y), gradient.z);
  const Mask some = hn::Eq(sum, sum);
  return {hn::IfThenElseZero(some, gradient.x), hn::IfThenElseZero(some, gradient.y),
          hn::IfThenElseZero(some, gradient.z)};
}

/// The eight texels around a place: corner[x + 2 * (y + 2 * z)].
struct Corners {
  Float corner[8];
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

HWY_INLINE Float trilinear(const Corners& at, const Vec3v& weight) {
  const auto& c = at.corner;
  const Float c00 = mix(c[0], c[1], weight.x), c10 = mix(c[2], c[3], weight.x);
  const Float c01 = mix(c[4], c[5], weight.x), c11 = mix(c[6], c[7], weight.x);
  return mix(mix(c00, c10, weight.y), mix(c01, c11, weight.y), weight.z);
}

template <typename Texels>
HWY_INLINE Float sample(const Texels& texels, int edge, const Vec3v& p) {
  const TexelPlace place(p, edge);
  return trilinear(texels.read(place.index, row_of(edge), row_of(edge) * row_of(edge)), place.weight);
}

/// brick::CellSample.
struct CellSample {
  Float value;
  Vec3v gradient;
};

/// Of several vectors of places at once; place_of(k) is a TexelPlace. Each thing is done for all before the
/// next: what one waits for, the others fill.
template <typename Texels, int kVectors, typename PlaceOf>
HWY_INLINE void cell_samples_at(const Texels& texels, int edge, const PlaceOf& place_of, bool with_gradient,
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
    const Corners at = Texels::corners(raw[k]);
    const auto& c = at.corner;
    const Vec3v& w = weight[k];
    const Float r00 = hn::Sub(c[1], c[0]), r10 = hn::Sub(c[3], c[2]);
    const Float r01 = hn::Sub(c[5], c[4]), r11 = hn::Sub(c[7], c[6]);
    const Float c00 = hn::MulAdd(w.x, r00, c[0]), c10 = hn::MulAdd(w.x, r10, c[2]);
    const Float c01 = hn::MulAdd(w.x, r01, c[4]), c11 = hn::MulAdd(w.x, r11, c[6]);
    const Float y0 = hn::Sub(c10, c00), y1 = hn::Sub(c11, c01);
    const Float c0 = hn::MulAdd(w.y, y0, c00), c1 = hn::MulAdd(w.y, y1, c01);
    const Float z0 = hn::Sub(c1, c0);
    samples[k].value = hn::MulAdd(w.z, z0, c0);
    if (with_gradient) {
      samples[k].gradient = {mix(mix(r00, r10, w.y), mix(r01, r11, w.y), w.z), mix(y0, y1, w.z), z0};
    }
  }
}

template <typename Texels, int kVectors>
HWY_INLINE void cell_samples(const Texels& texels, int edge, const Vec3v (&p)[kVectors], bool with_gradient,
                             CellSample (&samples)[kVectors]) {
  cell_samples_at(
      texels, edge, [&](int k) HWY_ATTR { return TexelPlace(p[k], edge); }, with_gradient, samples);
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

template <int kVectors>
HWY_INLINE bool none_of(const Mask (&mask)[kVectors]) {
  Mask any = mask[0];
  for (int k = 1; k < kVectors; ++k) any = hn::Or(any, mask[k]);
  return none(any);
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
