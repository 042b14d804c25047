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
#include <type_traits>

#include <hwy/highway.h>

#include "gvx/render/vectors/quads_simd-inl.h"
#include "gvx/render/vectors/sample_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// brick::SplineAxis at a place from 0 to 1 in its cell.
struct SplineWeights {
  Float of_value[4], of_slope[4];

  HWY_INLINE explicit SplineWeights(Float t) {
    const Float one = all(1), sixth = all(1.0f / 6), half = all(0.5f);
    const Float s = hn::Sub(one, t), tt = hn::Mul(t, t), ss = hn::Mul(s, s);
    const auto inner = [&](Float square, Float u) HWY_ATTR {
      return hn::NegMulAdd(square, hn::NegMulAdd(half, u, one), all(2.0f / 3));
    };
    of_value[0] = hn::Mul(hn::Mul(ss, s), sixth);
    of_value[1] = inner(tt, t);
    of_value[2] = inner(ss, s);
    of_value[3] = hn::Mul(hn::Mul(tt, t), sixth);
    of_slope[0] = hn::Mul(ss, all(-0.5f));
    of_slope[1] = hn::Mul(t, hn::MulSub(all(1.5f), t, all(2)));
    of_slope[2] = hn::Mul(s, hn::NegMulAdd(all(1.5f), s, all(2)));
    of_slope[3] = hn::Mul(tt, half);
  }
};

/// A row of four texels along x.
struct Four {
  Float texel[4];
};

/// What a row of texels weighs, in its value and in its slope.
struct RowSums {
  Float value, slope;
};
HWY_INLINE RowSums sums_of(const Four& row, const SplineWeights& x) {
  RowSums sums{hn::Mul(x.of_value[0], row.texel[0]), hn::Mul(x.of_slope[0], row.texel[0])};
  for (int i = 1; i < 4; ++i) {
    sums.value = hn::MulAdd(x.of_value[i], row.texel[i], sums.value);
    sums.slope = hn::MulAdd(x.of_slope[i], row.texel[i], sums.slope);
  }
  return sums;
}

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

/// The 4 x 4 x 4 texels around a cell, in rows along x: row<j, k>() is the j-th along y and the k-th along z.
/// `index` is that of the texel at the cell's low corner.
template <typename Texels>
class WindowRows;

template <>
class WindowRows<PlainTexels<std::uint8_t>> {
 public:
  static constexpr bool kPairs = false;

  HWY_INLINE WindowRows(const PlainTexels<std::uint8_t>& texels, int edge, Int index)
      : first_(texels.texels - 1 - row_of(edge) - row_of(edge) * row_of(edge)),
        row_(row_of(edge)),
        index_(index) {}

  template <int j, int k>
  HWY_INLINE Four row() const {
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

  HWY_INLINE WindowRows(const PlainTexels<Voxel>& texels, int edge, Int index)
      : first_(texels.texels - 1 - row_of(edge) - row_of(edge) * row_of(edge)), row_(row_of(edge)) {
    store_offsets(hn::ShiftLeft < sizeof(Voxel) == 2 ? 1 : 2 > (index), offsets_);
  }

  template <int j, int k>
  HWY_INLINE RowSums sums(const PairWeights& x) const {
    Int part[4];
    load<j, k>(part);
    const Int bias = all_ints(static_cast<std::int32_t>(0x80008000u));
    return x.sums_of({hn::Xor(part[0], bias), hn::Xor(part[1], bias)});
  }
  template <int j, int k>
  HWY_INLINE Four row() const {
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
  static constexpr bool kPairs = false;

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
  HWY_INLINE Four row() const {
    constexpr int kShift = 8 * (j % 2 + 2 * (k % 2));
    const auto& quads = quads_[j / 2 + 2 * (k / 2)];
    return {{QuadTexels::byte<kShift>(quads[0]), QuadTexels::byte<kShift>(quads[1]),
             QuadTexels::byte<kShift>(quads[2]), QuadTexels::byte<kShift>(quads[3])}};
  }

 private:
  Int quads_[4][4];  // those of y 2j and z 2k at j + 2 k, along x
};

/// Calls function(std::integral_constant<int, i>) for i from 0 to 3.
template <typename Function>
HWY_INLINE void for_four(const Function& function) {
  function(std::integral_constant<int, 0>());
  function(std::integral_constant<int, 1>());
  function(std::integral_constant<int, 2>());
  function(std::integral_constant<int, 3>());
}

/// A place in a plane of a brick, and the texels that its gradient takes.
template <typename Texels>
class SplineWindow {
 public:
  HWY_INLINE SplineWindow(const Texels& texels, int edge, const Vec3v& p)
      : SplineWindow(texels, edge, TexelPlace(p, edge)) {}

  /// brick::spline_gradient; of() makes of a texel what is to be looked at.
  template <typename Of>
  HWY_INLINE Vec3v gradient_of(const Of& of) const {
    const SplineWeights x(weight_.x);
    return gradient_by([&](auto j, auto k) HWY_ATTR {
      const Four row = rows_.template row<j.value, k.value>();
      return sums_of({{of(row.texel[0]), of(row.texel[1]), of(row.texel[2]), of(row.texel[3])}}, x);
    });
  }
  HWY_INLINE Vec3v gradient() const {
    if constexpr (WindowRows<Texels>::kPairs) {
      const PairWeights x{SplineWeights(weight_.x)};
      const Vec3v sum =
          gradient_by([&](auto j, auto k) HWY_ATTR { return rows_.template sums<j.value, k.value>(x); });
      const Float unit = all(1.0f / PairWeights::kOne);
      return {hn::Mul(sum.x, unit), hn::Mul(sum.y, unit), hn::Mul(sum.z, unit)};
    } else {
      return gradient_of([](Float texel) HWY_ATTR { return texel; });
    }
  }

  /// The gradient of CellSample.
  HWY_INLINE Vec3v cell_gradient() const {
    const Four r00 = rows_.template row<1, 1>(), r10 = rows_.template row<2, 1>();
    const Four r01 = rows_.template row<1, 2>(), r11 = rows_.template row<2, 2>();
    const auto rise = [](const Four& row) HWY_ATTR { return hn::Sub(row.texel[2], row.texel[1]); };
    const auto value = [&](const Four& row) HWY_ATTR { return mix(row.texel[1], row.texel[2], weight_.x); };
    const Float c00 = value(r00), c10 = value(r10), c01 = value(r01), c11 = value(r11);
    const Float along_x =
        mix(mix(rise(r00), rise(r10), weight_.y), mix(rise(r01), rise(r11), weight_.y), weight_.z);
    const Float along_y = mix(hn::Sub(c10, c00), hn::Sub(c11, c01), weight_.z);
    return {along_x, along_y, hn::Sub(mix(c01, c11, weight_.y), mix(c00, c10, weight_.y))};
  }

 private:
  HWY_INLINE SplineWindow(const Texels& texels, int edge, const TexelPlace& place)
      : weight_(place.weight), rows_(texels, edge, place.index) {}

  /// sums(j, k) are those of a row.
  template <typename Sums>
  HWY_INLINE Vec3v gradient_by(const Sums& sums) const {
    const SplineWeights y(weight_.y), z(weight_.z);
    const Float zero = hn::Zero(kFloats);
    Vec3v sum{zero, zero, zero};
    for_four([&](auto k) HWY_ATTR {
      Float along_x = zero, along_y = zero, value = zero;
      for_four([&](auto j) HWY_ATTR {
        const RowSums row = sums(j, k);
        along_x = hn::MulAdd(y.of_value[j.value], row.slope, along_x);
        along_y = hn::MulAdd(y.of_slope[j.value], row.value, along_y);
        value = hn::MulAdd(y.of_value[j.value], row.value, value);
      });
      sum.x = hn::MulAdd(z.of_value[k.value], along_x, sum.x);
      sum.y = hn::MulAdd(z.of_value[k.value], along_y, sum.y);
      sum.z = hn::MulAdd(z.of_slope[k.value], value, sum.z);
    });
    return sum;
  }

  const Vec3v weight_;
  const WindowRows<Texels> rows_;
};

/// brick::gradient.
template <typename Texels>
HWY_INLINE Vec3v gradient(const Texels& texels, int edge, const Vec3v& p) {
  const SplineWindow<Texels> window(texels, edge, p);
  Vec3v smooth = window.gradient();
  if constexpr (!Texels::kWhole) {
    const Mask lacks = is_no_data(hn::Add(hn::Add(smooth.x, smooth.y), smooth.z));
    if (!none(lacks)) {
      const Vec3v of_cell = window.cell_gradient();
      smooth = {hn::IfThenElse(lacks, of_cell.x, smooth.x), hn::IfThenElse(lacks, of_cell.y, smooth.y),
                hn::IfThenElse(lacks, of_cell.z, smooth.z)};
    }
  }
  return smooth;
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
