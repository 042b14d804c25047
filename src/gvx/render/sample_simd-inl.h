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

#include "gvx/render/stretch_batch.h"
#include "gvx/render/unroll.h"

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

  /// Floats hold it exactly: a brick of 32 has 39304 texels.
  HWY_INLINE static Int index_of(Float x, Float y, Float z, Float row, Float slice) {
    return whole(hn::MulAdd(z, slice, hn::MulAdd(y, row, x)));
  }
  HWY_INLINE static Int index_of(Float x, Float y, Float z, int edge) {
    const auto row = static_cast<float>(edge + 2);
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
  HWY_INLINE explicit PlacesInside(int edge) {
    const int row = edge + 2;
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
  const auto* row = reinterpret_cast<const std::int32_t*>(table + offsets[0]);
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

/// The eight texels around a place: corner[x + 2 * (y + 2 * z)].
struct Corners {
  Float corner[8];
};

/// Texels as they are in a brick. load() and corners() are read() in two parts.
template <typename Voxel>
struct PlainTexels {
  static constexpr bool kWhole = std::is_integral_v<Voxel>;
  using Raw = Corners;
  const Voxel* texels;

  explicit PlainTexels(const std::byte* brick) : texels(reinterpret_cast<const Voxel*>(brick)) {}

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

/// Of each texel the four of which it is the low corner across x (StretchBatch::quads): two of these, side by
/// side, are all eight.
struct QuadTexels {
  static constexpr bool kWhole = true;
  struct Raw {
    Int low, high;  // along x; bytes y + 2 * z
  };
  const std::uint32_t* quads;

  HWY_INLINE Raw load(Int index, int, int) const {
#if HWY_TARGET == HWY_AVX2
    // Eight loads of eight bytes; as gathers, each lane of which is half of these, they would take thrice as
    // long.
    alignas(32) std::int32_t at[8];
    store_offsets(index, at);
    const auto two = [&](int a, int b) HWY_ATTR {
      const __m128i first = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(quads + at[a]));
      return _mm_loadh_pi(_mm_castsi128_ps(first), reinterpret_cast<const __m64*>(quads + at[b]));
    };
    const __m256 outer = _mm256_insertf128_ps(_mm256_castps128_ps256(two(0, 1)), two(4, 5), 1);
    const __m256 inner = _mm256_insertf128_ps(_mm256_castps128_ps256(two(2, 3)), two(6, 7), 1);
    return {Int{_mm256_castps_si256(_mm256_shuffle_ps(outer, inner, 0x88))},
            Int{_mm256_castps_si256(_mm256_shuffle_ps(outer, inner, 0xdd))}};
#elif HWY_TARGET == HWY_AVX3
    // Both of a lane at once, which halves what is gathered.
    constexpr int kBytes = sizeof(std::uint32_t);
    const __m512i first = _mm512_i32gather_epi64(_mm512_castsi512_si256(index.raw), quads, kBytes);
    const __m512i last = _mm512_i32gather_epi64(_mm512_extracti64x4_epi64(index.raw, 1), quads, kBytes);
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    const __m512i odd = _mm512_add_epi32(even, _mm512_set1_epi32(1));
    return {Int{_mm512_permutex2var_epi32(first, even, last)},
            Int{_mm512_permutex2var_epi32(first, odd, last)}};
#else
    const auto* base = reinterpret_cast<const std::int32_t*>(quads);
    return {hn::GatherIndex(kInts, base, index), hn::GatherIndex(kInts, base + 1, index)};
#endif
  }
  HWY_INLINE static Corners corners(const Raw& raw) {
    return {{byte<0>(raw.low), byte<0>(raw.high), byte<8>(raw.low), byte<8>(raw.high), byte<16>(raw.low),
             byte<16>(raw.high), byte<24>(raw.low), byte<24>(raw.high)}};
  }
  HWY_INLINE Corners read(Int index, int row, int slice) const {
    return corners(load(index, row, slice));
  }

  template <int kShift>
  HWY_INLINE static Float byte(Int four) {
    const hn::RebindToUnsigned<Ints> bits;
    if constexpr (kShift > 0) four = hn::BitCast(kInts, hn::ShiftRight<kShift>(hn::BitCast(bits, four)));
    return hn::ConvertTo(kFloats, kShift < 24 ? hn::And(four, all_ints(0xff)) : four);
  }
};

HWY_INLINE QuadTexels::Raw load_bytes(const QuadTexels& from, Int index, int row, int slice) {
  return from.load(index, row, slice);
}
HWY_INLINE PairsAlongZ pairs_along_z(const QuadTexels::Raw& raw) {
  const auto even = [](Int quad) HWY_ATTR { return hn::And(quad, all_ints(0x00ff00ff)); };
  const auto odd = [&](Int quad) HWY_ATTR {
#if HWY_TARGET == HWY_SCALAR
    return even(hn::ShiftRight<8>(quad));
#else
    const hn::Repartition<std::uint16_t, Ints> halves;
    return hn::BitCast(kInts, hn::ShiftRight<8>(hn::BitCast(halves, quad)));
#endif
  };
  return {{even(raw.low), even(raw.high), odd(raw.low), odd(raw.high)}};
}

/// Fills StretchBatch::quads from a brick of bytes.
HWY_INLINE void make_quads(StretchBatch& batch) {
  const auto* texels = reinterpret_cast<const std::uint8_t*>(batch.fine.brick);
  const std::size_t row = batch.m + 2, slice = row * row, count = plane_texels(batch.m) - slice - row;
  std::size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::Full128<std::uint8_t> bytes;
  const hn::Full128<std::uint16_t> pairs;
  const hn::Full128<std::uint32_t> quads;
  for (; i + 16 <= count; i += 16) {
    const auto at = [&](std::size_t offset) HWY_ATTR { return hn::LoadU(bytes, texels + i + offset); };
    const auto a = at(0), b = at(row), c = at(slice), d = at(slice + row);
    const auto pair = [&](auto v) HWY_ATTR { return hn::BitCast(pairs, v); };
    const auto front_low = pair(hn::InterleaveLower(bytes, a, b));
    const auto front_high = pair(hn::InterleaveUpper(bytes, a, b));
    const auto back_low = pair(hn::InterleaveLower(bytes, c, d));
    const auto back_high = pair(hn::InterleaveUpper(bytes, c, d));
    const auto put = [&](auto v, std::size_t offset)
                         HWY_ATTR { hn::StoreU(hn::BitCast(quads, v), quads, batch.quads + i + offset); };
    put(hn::InterleaveLower(pairs, front_low, back_low), 0);
    put(hn::InterleaveUpper(pairs, front_low, back_low), 4);
    put(hn::InterleaveLower(pairs, front_high, back_high), 8);
    put(hn::InterleaveUpper(pairs, front_high, back_high), 12);
  }
#endif
  for (; i < count; ++i) {
    const std::uint32_t front = texels[i] | texels[i + row] << 8;
    const std::uint32_t back = texels[i + slice] | texels[i + slice + row] << 8;
    batch.quads[i] = front | back << 16;
  }
}

/// Makes quads of the fine brick of bytes where the batch's rays take so many steps that it pays.
HWY_INLINE bool makes_quads(StretchBatch& batch) {
  constexpr std::size_t kStepsOfVectors = 24;
  const std::size_t least = kStepsOfVectors * hn::Lanes(kFloats);
  std::size_t steps = 0;
  for (std::uint32_t i = 0; i < batch.count && steps <= least; ++i) steps += batch.length[i];
  if (steps <= least) return false;
  make_quads(batch);
  return true;
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
  return trilinear(texels.read(place.index, edge + 2, (edge + 2) * (edge + 2)), place.weight);
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
      texels.load(index[k], edge + 2, (edge + 2) * (edge + 2));
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
  static constexpr bool kBytes =
      std::is_same_v<Texels, QuadTexels> || std::is_same_v<Texels, PlainTexels<std::uint8_t>>;
  /// Values of bytes: first along z, in whole numbers, where texels weigh so many 2^14ths. (With gradients
  /// that is no gain: these are of differences along x first.)
  static constexpr bool kInWholeNumbers = kBytes && !kGradient;
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
      bytes[k] = load_bytes(texels_, place.index, edge_ + 2, (edge_ + 2) * (edge_ + 2));
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

/// Along one axis of a voxel, at a place from 0 to 1 in it: what its texel and its neighbours weigh in the
/// value and in the difference of half a voxel to either side.
struct ThreeTexels {
  Float of_value[3], of_difference[3];

  HWY_INLINE explicit ThreeTexels(Float in_voxel) {
    const Float zero = hn::Zero(kFloats), one = all(1);
    const Float from_centre = hn::Sub(in_voxel, all(0.5f));
    of_value[0] = hn::Max(hn::Neg(from_centre), zero);
    of_value[1] = hn::Sub(one, hn::Abs(from_centre));
    of_value[2] = hn::Max(from_centre, zero);
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

/// The 3 x 3 x 3 texels around a voxel, in rows along x: those of y j and z k at j + 3 k. All that the
/// gradients of a voxel need.
struct Around {
  Vec3v first;  ///< the low corner of the voxel
  Triple rows[9];

  template <typename Texels>
  HWY_INLINE void read(const Texels& texels, int edge, const Vec3v& p) {
    first = {first_of(p.x, edge), first_of(p.y, edge), first_of(p.z, edge)};
    read_rows(texels, edge, TexelPlace::index_of(first.x, first.y, first.z, edge));
  }

  /// brick::gradient at a place in this voxel.
  HWY_INLINE Vec3v gradient(const Vec3v& p) const {
    const ThreeTexels x(hn::Sub(p.x, first.x)), y(hn::Sub(p.y, first.y)), z(hn::Sub(p.z, first.z));
    Float along_x[3], along_y[3], value[3];
    for (int k = 0; k < 3; ++k) {
      Float row_value[3], row_difference[3];
      for (int j = 0; j < 3; ++j) {
        const auto& t = rows[j + 3 * k].texel;
        row_value[j] = weighted(x.of_value, t[0], t[1], t[2]);
        row_difference[j] = weighted(x.of_difference, t[0], t[1], t[2]);
      }
      value[k] = weighted(y.of_value, row_value[0], row_value[1], row_value[2]);
      along_x[k] = weighted(y.of_value, row_difference[0], row_difference[1], row_difference[2]);
      along_y[k] = weighted(y.of_difference, row_value[0], row_value[1], row_value[2]);
    }
    return {weighted(z.of_value, along_x[0], along_x[1], along_x[2]),
            weighted(z.of_value, along_y[0], along_y[1], along_y[2]),
            weighted(z.of_difference, value[0], value[1], value[2])};
  }

 private:
  HWY_INLINE static Float first_of(Float position, int edge) {
    const Float last = all(static_cast<float>(edge - 1));
    return hn::Min(hn::Floor(hn::Max(position, hn::Zero(kFloats))), last);
  }
  template <typename Voxel>
  HWY_INLINE void read_rows(const PlainTexels<Voxel>& texels, int edge, Int index) {
    const int row = edge + 2, slice = row * row;
    for (int i = 0; i < 9; ++i) {
      rows[i] = gather_triple(texels.texels + i % 3 * row + i / 3 * slice, index);
    }
  }
  HWY_INLINE void read_rows(const QuadTexels& texels, int edge, Int index) {
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
  return around.gradient(held(p, edge));
}

/// deviation_of_code of the byte at each index.
HWY_INLINE Float meaning_of_codes(Int codes) {
  const Int code = hn::And(codes, all_ints(0xff));
  // A code is the exponent and the first bits of the mantissa of a float.
  const Int bits = hn::Add(hn::ShiftLeft<19>(code), all_ints(127 << 23));
  return hn::IfThenElseZero(hn::RebindMask(kFloats, hn::Gt(code, hn::Zero(kInts))),
                            hn::BitCast(kFloats, bits));
}

/// brick::deviation; `deviations` are of a brick of this edge.
HWY_INLINE Float deviation(const std::uint8_t* deviations, int brick_edge, const Vec3v& p) {
  float unit;
  std::memcpy(&unit, deviations, sizeof(unit));
  if (!(unit > 0.0f)) return hn::Zero(kFloats);
  const std::uint8_t* codes = deviations + sizeof(unit);
  const int edge = brick_edge / 2, row = edge + 2, slice = row * row;
  const Float half = all(0.5f);
  const TexelPlace place({hn::Mul(p.x, half), hn::Mul(p.y, half), hn::Mul(p.z, half)}, edge);
  const Vec3v& weight = place.weight;
  // The last texels' neighbours are read with those before them: a brick ends with its deviations.
  Float along_x[4];
  for (int i = 0; i < 4; ++i) {
    const int offset = (i & 1) * row + (i >> 1) * slice - 2;
    const Int four =
        hn::GatherOffset(kInts, reinterpret_cast<const std::int32_t*>(codes + offset), place.index);
    along_x[i] =
        mix(meaning_of_codes(hn::ShiftRight<16>(four)), meaning_of_codes(hn::ShiftRight<24>(four)), weight.x);
  }
  return hn::Mul(all(unit),
                 mix(mix(along_x[0], along_x[1], weight.y), mix(along_x[2], along_x[3], weight.y), weight.z));
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
