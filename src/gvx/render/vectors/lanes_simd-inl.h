/// \file
/// Lanes of Highway's vectors: their types, what the formulas (formula/one_lane.h) need of them, and how rows
/// of memory come into them. Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_LANES_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_LANES_SIMD_INL_H
#undef GVX_RENDER_LANES_SIMD_INL_H
#else
#define GVX_RENDER_LANES_SIMD_INL_H
#endif

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include <hwy/highway.h>

#include "gvx/render/vectors/simd_targets.h"

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

constexpr bool kOneLane = false;

HWY_INLINE Float all(float value) {
  return hn::Set(kFloats, value);
}
HWY_INLINE Int all_ints(std::int32_t value) {
  return hn::Set(kInts, value);
}
HWY_INLINE bool none(Mask mask) {
  return hn::AllFalse(kFloats, mask);
}

HWY_INLINE Mask is_no_data(Float value) {
  return hn::IsNaN(value);  // Ne is ordered on x86, and false
}

struct Vec3v {
  Float x, y, z;
};
HWY_INLINE Float dot(const Vec3v& a, const Vec3v& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
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

/// The same as floats.
HWY_INLINE Float whole_part(Float value) {
  return hn::Floor(value);
}

/// Stores whole numbers that are to be read one by one, from memory: to take a vector apart takes longer.
HWY_INLINE void store_offsets(Int values, std::int32_t* offsets) {
  hn::Store(values, kInts, offsets);
#if defined(__GNUC__)
  __asm__("" : "+m"(*reinterpret_cast<std::int32_t(*)[hn::MaxLanes(kInts)]>(offsets)));
#endif
}

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

/// Calls function(std::integral_constant<int, i>) for i from 0 to 3.
template <typename Function>
HWY_INLINE void for_four(const Function& function) {
  function(std::integral_constant<int, 0>());
  function(std::integral_constant<int, 1>());
  function(std::integral_constant<int, 2>());
  function(std::integral_constant<int, 3>());
}

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
