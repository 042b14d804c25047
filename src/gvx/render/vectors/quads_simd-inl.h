/// \file
/// QuadTexels: bricks of bytes laid out anew, so that what a sample needs lies together.
/// Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_QUADS_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_QUADS_SIMD_INL_H
#undef GVX_RENDER_QUADS_SIMD_INL_H
#else
#define GVX_RENDER_QUADS_SIMD_INL_H
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/sample_simd-inl.h"
#include "gvx/render/vectors/simd_targets.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// Of each texel the four of which it is the low corner across x (StretchBatch::quads): two of these, side by
/// side, are all eight.
struct QuadTexels {
  static constexpr bool kWhole = true, kBytes = true;
  struct Raw {
    Int low, high;  // along x; bytes y + 2 * z
  };
  const std::uint32_t* quads;  // of corner_texel and behind it

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
    constexpr int kQuad = sizeof(std::uint32_t);
    const __m512i first = _mm512_i32gather_epi64(_mm512_castsi512_si256(index.raw), quads, kQuad);
    const __m512i last = _mm512_i32gather_epi64(_mm512_extracti64x4_epi64(index.raw, 1), quads, kQuad);
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

/// Rows of texels along x: those of y from the first to the last, z likewise.
struct TexelRows {
  std::size_t first_y, last_y, first_z, last_z;
};

/// Lays numbers out anew, of each texel of some rows: itself, the next along y, the next along z, and the one
/// that is next along both, from the lowest bits up. `row` texels are a row, as many rows a slice.
template <typename Number, typename Quad>
HWY_INLINE void make_quads(const Number* numbers, std::size_t row, const TexelRows& rows, Quad* quads) {
  static_assert(sizeof(Quad) == 4 * sizeof(Number));
  const std::size_t slice = row * row;
  for (std::size_t z = rows.first_z; z <= rows.last_z; ++z) {
    const std::size_t end = z * slice + (rows.last_y + 1) * row;
    std::size_t i = z * slice + rows.first_y * row;
#if HWY_TARGET != HWY_SCALAR
    const hn::Full128<Number> ones;
    const hn::RepartitionToWide<decltype(ones)> pairs;
    const hn::RepartitionToWide<decltype(pairs)> fours;
    for (; i + hn::Lanes(ones) <= end; i += hn::Lanes(ones)) {
      const auto at = [&](std::size_t offset) HWY_ATTR { return hn::LoadU(ones, numbers + i + offset); };
      const auto a = at(0), b = at(row), c = at(slice), d = at(slice + row);
      const auto pair = [&](auto v) HWY_ATTR { return hn::BitCast(pairs, v); };
      const auto front_low = pair(hn::InterleaveLower(ones, a, b));
      const auto front_high = pair(hn::InterleaveUpper(ones, a, b));
      const auto back_low = pair(hn::InterleaveLower(ones, c, d));
      const auto back_high = pair(hn::InterleaveUpper(ones, c, d));
      const auto put = [&](auto v, std::size_t part) HWY_ATTR {
        hn::StoreU(hn::BitCast(fours, v), fours, quads + i + part * hn::Lanes(fours));
      };
      put(hn::InterleaveLower(pairs, front_low, back_low), 0);
      put(hn::InterleaveUpper(pairs, front_low, back_low), 1);
      put(hn::InterleaveLower(pairs, front_high, back_high), 2);
      put(hn::InterleaveUpper(pairs, front_high, back_high), 3);
    }
#endif
    constexpr int kBits = 8 * sizeof(Number);
    for (; i < end; ++i) {
      const Quad front = numbers[i] | Quad(numbers[i + row]) << kBits;
      const Quad back = numbers[i + slice] | Quad(numbers[i + slice + row]) << kBits;
      quads[i] = front | back << 2 * kBits;
    }
  }
}

/// Those of a path's brick of bytes, as far as its rays come; with those around them that gradients take.
HWY_INLINE void make_quads(std::uint32_t m, bool gradients, StretchBatch::Path& path) {
  const std::size_t border = kBrickBorder - 1, rim = gradients ? border : 0;
  const auto first = [&](int axis) { return path.first_row[axis] + border - rim; };
  const auto last = [&](int axis) { return std::min(path.last_row[axis], m) + border + rim; };
  make_quads(reinterpret_cast<const std::uint8_t*>(path.brick),
             static_cast<std::size_t>(row_of(static_cast<int>(m))), {first(0), last(0), first(1), last(1)},
             path.quads);
}

/// What make_quads has made.
HWY_INLINE QuadTexels quads_of(std::uint32_t m, const StretchBatch::Path& path) {
  return {path.quads + corner_texel(static_cast<int>(m))};
}

/// Do the batch's rays take so many steps that it pays to lay bricks out anew? Sooner where a step takes more
/// from them.
HWY_INLINE bool pays_to_lay_out(const StretchBatch& batch) {
  const std::size_t steps_of_vectors = batch.blended || batch.fine.deviates ? 4 : 16;
  const std::size_t least = steps_of_vectors * hn::Lanes(kFloats);
  std::size_t steps = 0;
  for (std::uint32_t i = 0; i < batch.count && steps <= least; ++i) steps += batch.length[i];
  return steps > least;
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
