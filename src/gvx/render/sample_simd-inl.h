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

#include <cstddef>
#include <cstdint>
#include <cstring>

#include <hwy/highway.h>

#include "gvx/render/stretch_batch.h"
#include "gvx/render/visible_cells.h"

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
HWY_INLINE Vec3v load(const float (&values)[3][StretchBatch::kMost], std::size_t lane) {
  return {hn::Load(kFloats, values[0] + lane), hn::Load(kFloats, values[1] + lane),
          hn::Load(kFloats, values[2] + lane)};
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

/// brick::TexelAxis.
struct TexelAxis {
  Int low;
  Float weight;

  HWY_INLINE TexelAxis(Float position, int edge) {
    const Float texel =
        hn::Min(hn::Max(hn::Add(position, all(0.5f)), hn::Zero(kFloats)), all(static_cast<float>(edge + 1)));
    low = hn::Min(hn::ConvertTo(kInts, texel), all_ints(edge));
    weight = hn::Sub(texel, hn::ConvertTo(kFloats, low));
  }
};

HWY_INLINE Float mix(Float a, Float b, Float weight) {
  return hn::MulAdd(weight, hn::Sub(b, a), a);
}

/// The eight texels around a place: corner[x + 2 * (y + 2 * z)].
struct Corners {
  Float corner[8];
};

/// Texels as they are in a brick.
template <typename Voxel>
struct PlainTexels {
  const Voxel* texels;

  explicit PlainTexels(const std::byte* brick) : texels(reinterpret_cast<const Voxel*>(brick)) {}

  HWY_INLINE Corners read(Int index, int row, int slice) const {
    const Pair p00 = gather_pair(texels, index), p10 = gather_pair(texels + row, index);
    const Pair p01 = gather_pair(texels + slice, index), p11 = gather_pair(texels + slice + row, index);
    return {{p00.low, p00.high, p10.low, p10.high, p01.low, p01.high, p11.low, p11.high}};
  }
};

/// Each texel beside the one behind it along y: two gathers find all eight.
struct PairedRows {
  const std::uint16_t* pairs;

  HWY_INLINE Corners read(Int index, int, int slice) const {
    const auto* base = reinterpret_cast<const std::int32_t*>(pairs);
    const Int front = hn::GatherOffset(kInts, base, hn::ShiftLeft<1>(index));
    const Int back = hn::GatherOffset(kInts, base, hn::ShiftLeft<1>(hn::Add(index, all_ints(slice))));
    return {{byte<0>(front), byte<16>(front), byte<8>(front), byte<24>(front), byte<0>(back), byte<16>(back),
             byte<8>(back), byte<24>(back)}};
  }

 private:
  template <int kShift>
  HWY_INLINE static Float byte(Int four) {
    if constexpr (kShift > 0) four = hn::ShiftRight<kShift>(four);
    return hn::ConvertTo(kFloats, hn::And(four, all_ints(0xff)));
  }
};

/// Fills StretchBatch::row_pairs from a brick of bytes.
HWY_INLINE void pair_rows(StretchBatch& batch) {
  const hn::ScalableTag<std::uint16_t> words;
  const hn::Rebind<std::uint8_t, decltype(words)> bytes;
  const auto* texels = reinterpret_cast<const std::uint8_t*>(batch.fine.brick);
  const std::size_t row = batch.m + 2, count = plane_texels(batch.m) - row;
  std::size_t i = 0;
  for (; i + hn::Lanes(words) <= count; i += hn::Lanes(words)) {
    const auto here = hn::PromoteTo(words, hn::LoadU(bytes, texels + i));
    const auto behind = hn::PromoteTo(words, hn::LoadU(bytes, texels + i + row));
    hn::StoreU(hn::Or(here, hn::ShiftLeft<8>(behind)), words, batch.row_pairs + i);
  }
  for (; i < count; ++i) {
    batch.row_pairs[i] = static_cast<std::uint16_t>(texels[i] | texels[i + row] << 8);
  }
}

/// Pairs the rows of the fine brick of bytes where the batch's rays take so many steps that it pays.
HWY_INLINE bool pairs_rows(StretchBatch& batch) {
  constexpr std::int64_t kLongSteps = 24;
  std::int64_t steps = 0;
  for (std::uint32_t i = 0; i < batch.count; ++i) steps += batch.steps[i];
  if (steps <= kLongSteps * static_cast<std::int64_t>(hn::Lanes(kFloats))) return false;
  pair_rows(batch);
  return true;
}

/// Is the cell at p one that can be seen (visible_cells.h)?
HWY_INLINE Mask in_visible_cell(std::uint64_t cells, int edge, const Vec3v& p) {
  const Float cells_per_voxel = all(static_cast<float>(kCellsAcross) / static_cast<float>(edge));
  const auto cell = [&](Float x) HWY_ATTR {
    const Float held = hn::Min(hn::Max(hn::Mul(x, cells_per_voxel), hn::Zero(kFloats)),
                               all(static_cast<float>(kCellsAcross) - 0.5f));
    return hn::ConvertTo(kInts, held);
  };
  const Int index = hn::Add(cell(p.x), hn::Add(hn::ShiftLeft<2>(cell(p.y)), hn::ShiftLeft<4>(cell(p.z))));
  const Int low = all_ints(static_cast<std::int32_t>(cells & 0xffffffffu));
  const Int high = all_ints(static_cast<std::int32_t>(cells >> 32));
  const Int half = hn::IfThenElse(hn::Gt(index, all_ints(31)), high, low);
  const Int bit = hn::Shl(all_ints(1), hn::And(index, all_ints(31)));
  return hn::RebindMask(kFloats, hn::Ne(hn::And(half, bit), hn::Zero(kInts)));
}

template <typename Texels>
HWY_INLINE Float sample(const Texels& texels, int edge, const Vec3v& p) {
  const int row = edge + 2, slice = row * row;
  const TexelAxis x(p.x, edge), y(p.y, edge), z(p.z, edge);
  const Int index = hn::Add(x.low, hn::Add(hn::Mul(y.low, all_ints(row)), hn::Mul(z.low, all_ints(slice))));
  const Corners at = texels.read(index, row, slice);
  const auto& c = at.corner;
  const Float c00 = mix(c[0], c[1], x.weight), c10 = mix(c[2], c[3], x.weight);
  const Float c01 = mix(c[4], c[5], x.weight), c11 = mix(c[6], c[7], x.weight);
  return mix(mix(c00, c10, y.weight), mix(c01, c11, y.weight), z.weight);
}

/// Along one axis: the first of the three texels around a place from 0 to `edge`, and what each of them
/// weighs in the value and in the difference of half a voxel to either side.
struct ThreeTexels {
  Int first;
  Float of_value[3], of_difference[3];

  HWY_INLINE ThreeTexels(Float position, int edge) {
    const Float zero = hn::Zero(kFloats), one = all(1), half = all(0.5f);
    const Float held = hn::Min(hn::Max(position, zero), all(static_cast<float>(edge)));
    first = hn::Min(hn::ConvertTo(kInts, held), all_ints(edge - 1));
    const Float in_voxel = hn::Sub(held, hn::ConvertTo(kFloats, first));
    const Float from_centre = hn::Sub(in_voxel, half);
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
  // The fourth byte is the deviations' first at most.
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

/// brick::gradient: all that it needs is in 3 x 3 x 3 texels.
template <typename Voxel>
HWY_INLINE Vec3v gradient(const Voxel* texels, int edge, const Vec3v& p) {
  const int row = edge + 2, slice = row * row;
  const ThreeTexels x(p.x, edge), y(p.y, edge), z(p.z, edge);
  const Int index =
      hn::Add(x.first, hn::Add(hn::Mul(y.first, all_ints(row)), hn::Mul(z.first, all_ints(slice))));
  Float along_x[3], along_y[3], value[3];
  for (int k = 0; k < 3; ++k) {
    Float row_value[3], row_difference[3];
    for (int j = 0; j < 3; ++j) {
      const Triple t = gather_triple(texels + j * row + k * slice, index);
      row_value[j] = weighted(x.of_value, t.texel[0], t.texel[1], t.texel[2]);
      row_difference[j] = weighted(x.of_difference, t.texel[0], t.texel[1], t.texel[2]);
    }
    value[k] = weighted(y.of_value, row_value[0], row_value[1], row_value[2]);
    along_x[k] = weighted(y.of_value, row_difference[0], row_difference[1], row_difference[2]);
    along_y[k] = weighted(y.of_difference, row_value[0], row_value[1], row_value[2]);
  }
  return {weighted(z.of_value, along_x[0], along_x[1], along_x[2]),
          weighted(z.of_value, along_y[0], along_y[1], along_y[2]),
          weighted(z.of_difference, value[0], value[1], value[2])};
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
  const TexelAxis x(hn::Mul(p.x, half), edge), y(hn::Mul(p.y, half), edge), z(hn::Mul(p.z, half), edge);
  // The last texels' neighbours are read with those before them: a brick ends with its deviations.
  const Int index = hn::Add(x.low, hn::Add(hn::Mul(y.low, all_ints(row)), hn::Mul(z.low, all_ints(slice))));
  Float along_x[4];
  for (int i = 0; i < 4; ++i) {
    const int offset = (i & 1) * row + (i >> 1) * slice - 2;
    const Int four = hn::GatherOffset(kInts, reinterpret_cast<const std::int32_t*>(codes + offset), index);
    along_x[i] =
        mix(meaning_of_codes(hn::ShiftRight<16>(four)), meaning_of_codes(hn::ShiftRight<24>(four)), x.weight);
  }
  return hn::Mul(all(unit),
                 mix(mix(along_x[0], along_x[1], y.weight), mix(along_x[2], along_x[3], y.weight), z.weight));
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
