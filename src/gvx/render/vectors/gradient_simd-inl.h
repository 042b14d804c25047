/// \file
/// How gradients read the rows of a brick in vectors (reference/sample.h does it for one ray). Compiled once
/// for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_GRADIENT_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_GRADIENT_SIMD_INL_H
#undef GVX_RENDER_GRADIENT_SIMD_INL_H
#else
#define GVX_RENDER_GRADIENT_SIMD_INL_H
#endif

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <hwy/highway.h>

#include "gvx/render/vectors/quads_simd-inl.h"
#include "gvx/render/vectors/sample_simd-inl.h"
#include "gvx/render/vectors/simd_targets.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

#include "gvx/render/formula/gradient.inc"

/// The weights of rows of 16-bit numbers, two to a lane, in so many 2^14ths. Their sums are exactly those of
/// the spline, 1 and 0: what all numbers have in common changes no gradient, and sums may leave out 2^15.
struct PairWeights {
  static constexpr std::int32_t kOne = 1 << 14;
  Int of_value[2], of_slope[2];

  HWY_INLINE explicit PairWeights(const SplineWeights& x) {
    put(x.of_value, kOne, of_value);
    put(x.of_slope, 0, of_slope);
  }

  /// Of a row's numbers, less 2^15 each; times kOne.
  HWY_INLINE RowSums sums_of(const Int (&numbers)[2]) const {
    const auto sum = [&](const Int(&weights)[2]) HWY_ATTR {
      return hn::ConvertTo(
          kFloats, hn::Add(sum_of_products(numbers[0], weights[0]), sum_of_products(numbers[1], weights[1])));
    };
    return {sum(of_value), sum(of_slope)};
  }

 private:
  /// What the third weighs is what is left of their sum.
  HWY_INLINE static void put(const Float (&weights)[4], std::int32_t sum, Int (&pairs)[2]) {
    const auto whole_part = [](Float weight) HWY_ATTR { return hn::NearestInt(hn::Mul(weight, all(kOne))); };
    const Int first = whole_part(weights[0]), second = whole_part(weights[1]), last = whole_part(weights[3]);
    const Int third = hn::Sub(all_ints(sum), hn::Add(hn::Add(first, second), last));
    const auto pair = [](Int low, Int high) HWY_ATTR {
      return hn::Or(hn::And(low, all_ints(0xffff)), hn::ShiftLeft<16>(high));
    };
    pairs[0] = pair(first, second);
    pairs[1] = pair(third, last);
  }
};

template <int i>
using Index = std::integral_constant<int, i>;

template <typename Rows, typename J, typename K>
HWY_INLINE RowSums row_sums(const Rows& rows, J j, K k, const PairWeights& x) {
  return rows.sums(j, k, x);
}

template <>
class WindowRows<PlainTexels<std::uint8_t>> {
 public:
  using Weights = SplineWeights;
  static constexpr float kUnit = 1;

  HWY_INLINE WindowRows(const PlainTexels<std::uint8_t>& texels, int edge, Int index)
      : first_(texels.texels - 1 - row_of(edge) - row_of(edge) * row_of(edge)),
        row_(row_of(edge)),
        index_(index) {}

  template <int j, int k>
  HWY_INLINE Four row(Index<j>, Index<k>) const {
    const std::uint8_t* row = first_ + (j + k * row_) * row_;
    const Int four = hn::GatherOffset(kInts, reinterpret_cast<const std::int32_t*>(row), index_);
    return {{QuadTexels::byte<0>(four), QuadTexels::byte<8>(four), QuadTexels::byte<16>(four),
             QuadTexels::byte<24>(four)}};
  }

 private:
  const std::uint8_t* first_;
  const int row_;
  const Int index_;
};

/// Of numbers of two or four bytes: rows are loaded whole. (Of two bytes twice as many are loaded; what lies
/// behind a brick may be read: BrickPool leaves room there.)
template <typename Voxel>
class WindowRows<PlainTexels<Voxel>> {
 public:
  static constexpr bool kPairs = sizeof(Voxel) == 2;
  using Weights = std::conditional_t<kPairs, PairWeights, SplineWeights>;
  static constexpr float kUnit = kPairs ? PairWeights::kOne : 1;

  HWY_INLINE WindowRows(const PlainTexels<Voxel>& texels, int edge, Int index)
      : first_(texels.texels - 1 - row_of(edge) - row_of(edge) * row_of(edge)), row_(row_of(edge)) {
    store_offsets(hn::ShiftLeft < sizeof(Voxel) == 2 ? 1 : 2 > (index), offsets_);
  }

  template <int j, int k>
  HWY_INLINE RowSums sums(Index<j>, Index<k>, const PairWeights& x) const {
    Int part[4];
    load<j, k>(part);
    const Int bias = all_ints(static_cast<std::int32_t>(0x80008000u));
    return x.sums_of({hn::Xor(part[0], bias), hn::Xor(part[1], bias)});
  }
  template <int j, int k>
  HWY_INLINE Four row(Index<j>, Index<k>) const {
    Int part[4];
    load<j, k>(part);
    if constexpr (std::is_floating_point_v<Voxel>) {
      const auto number = [&](int i) HWY_ATTR { return hn::BitCast(kFloats, part[i]); };
      return {{number(0), number(1), number(2), number(3)}};
    } else {
      const hn::RebindToUnsigned<Ints> bits;
      const auto low = [&](Int two)
                           HWY_ATTR { return hn::ConvertTo(kFloats, hn::And(two, all_ints(0xffff))); };
      const auto high = [&](Int two) HWY_ATTR {
        return hn::ConvertTo(kFloats, hn::BitCast(kInts, hn::ShiftRight<16>(hn::BitCast(bits, two))));
      };
      return {{low(part[0]), high(part[0]), low(part[1]), high(part[1])}};
    }
  }

 private:
  template <int j, int k>
  HWY_INLINE void load(Int (&part)[4]) const {
    load_rows(reinterpret_cast<const std::byte*>(first_ + (j + k * row_) * row_), offsets_, part);
  }

  const Voxel* first_;
  const int row_;
  alignas(64) std::int32_t offsets_[hn::MaxLanes(kInts)];
};

template <>
class WindowRows<QuadTexels> {
 public:
  using Weights = SplineWeights;
  static constexpr float kUnit = 1;

  HWY_INLINE WindowRows(const QuadTexels& texels, int edge, Int index) {
    const int row = row_of(edge), slice = row * row;
    alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
    store_offsets(hn::ShiftLeft<2>(index), offsets);
    const std::uint32_t* first = texels.quads - 1 - row - slice;
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t* quads = first + 2 * (i % 2) * row + 2 * (i / 2) * slice;
      load_rows(reinterpret_cast<const std::byte*>(quads), offsets, quads_[i]);
    }
  }

  template <int j, int k>
  HWY_INLINE Four row(Index<j>, Index<k>) const {
    constexpr int kShift = 8 * (j % 2 + 2 * (k % 2));
    const auto& quads = quads_[j / 2 + 2 * (k / 2)];
    return {{QuadTexels::byte<kShift>(quads[0]), QuadTexels::byte<kShift>(quads[1]),
             QuadTexels::byte<kShift>(quads[2]), QuadTexels::byte<kShift>(quads[3])}};
  }

 private:
  Int quads_[4][4];  // those of y 2j and z 2k at j + 2 k, along x
};

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
