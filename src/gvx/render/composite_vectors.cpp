// composite_batch: composite.h once more, with a ray in each lane of a vector. What is said there holds here;
// the same names mean the same. Compiled once for each instruction set.

#include <cstddef>
#include <cstring>

#include "gvx/core/voxel.h"
#include "gvx/render/composite.h"
#include "gvx/render/stretch_batch.h"

// What lies between these or has vectors without a fixed size gains nothing here.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/composite_vectors.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
// clang-format on

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
HWY_INLINE Float opacity_of(Float depth) {
  return hn::Sub(all(1), hn::Exp(kFloats, hn::Neg(depth)));
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

template <typename Voxel>
HWY_INLINE Float trilinear(const Voxel* texels, int edge, const TexelAxis& x, const TexelAxis& y,
                           const TexelAxis& z) {
  const int row = edge + 2, slice = row * row;
  const Int index = hn::Add(x.low, hn::Add(hn::Mul(y.low, all_ints(row)), hn::Mul(z.low, all_ints(slice))));
  const Pair p00 = gather_pair(texels, index), p10 = gather_pair(texels + row, index);
  const Pair p01 = gather_pair(texels + slice, index), p11 = gather_pair(texels + slice + row, index);
  const Float c00 = mix(p00.low, p00.high, x.weight), c10 = mix(p10.low, p10.high, x.weight);
  const Float c01 = mix(p01.low, p01.high, x.weight), c11 = mix(p11.low, p11.high, x.weight);
  return mix(mix(c00, c10, y.weight), mix(c01, c11, y.weight), z.weight);
}

template <typename Voxel>
HWY_INLINE Float sample(const Voxel* texels, int edge, const Vec3v& p) {
  return trilinear(texels, edge, TexelAxis(p.x, edge), TexelAxis(p.y, edge), TexelAxis(p.z, edge));
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

/// scene::Matter.
struct Matter {
  Float part[4];  // r, g, b, extinction
};
HWY_INLINE Matter select(Mask mask, const Matter& a, const Matter& b) {
  Matter m;
  for (int i = 0; i < 4; ++i) m.part[i] = hn::IfThenElse(mask, a.part[i], b.part[i]);
  return m;
}

/// Four 32-bit numbers of each lane, table + offset in bytes onwards: out[i] has the i-th of every lane. Rows
/// are loaded whole and turned, which is several times as fast as gathering.
HWY_INLINE void load_rows(const std::byte* table, const std::int32_t* offsets, Int out[4]) {
#if HWY_TARGET == HWY_SCALAR
  const auto* row = reinterpret_cast<const std::int32_t*>(table + offsets[0]);
  for (std::size_t i = 0; i < 4; ++i) out[i] = hn::Set(kInts, row[i]);
#else
  const auto row = [&](std::size_t lane) HWY_ATTR {
    const auto* numbers = reinterpret_cast<const std::int32_t*>(table + offsets[lane]);
    return hn::Load(hn::Full128<std::int32_t>(), numbers);
  };
  Int part[4];
  for (std::size_t i = 0; i < 4; ++i) {
#if HWY_MAX_BYTES == 16
    part[i] = row(i);
#elif HWY_MAX_BYTES == 32
    part[i] = hn::Combine(kInts, row(4 + i), row(i));
#else
    const hn::Half<Ints> half;
    part[i] =
        hn::Combine(kInts, hn::Combine(half, row(12 + i), row(8 + i)), hn::Combine(half, row(4 + i), row(i)));
#endif
  }
  const hn::RepartitionToWide<Ints> pairs;
  const auto pair = [&](Int v) HWY_ATTR { return hn::BitCast(pairs, v); };
  const Int a = hn::InterleaveLower(kInts, part[0], part[1]),
            b = hn::InterleaveUpper(kInts, part[0], part[1]);
  const Int c = hn::InterleaveLower(kInts, part[2], part[3]),
            d = hn::InterleaveUpper(kInts, part[2], part[3]);
  out[0] = hn::BitCast(kInts, hn::InterleaveLower(pairs, pair(a), pair(c)));
  out[1] = hn::BitCast(kInts, hn::InterleaveUpper(pairs, pair(a), pair(c)));
  out[2] = hn::BitCast(kInts, hn::InterleaveLower(pairs, pair(b), pair(d)));
  out[3] = hn::BitCast(kInts, hn::InterleaveUpper(pairs, pair(b), pair(d)));
#endif
}

/// scene::TransferView::Reading.
struct Reading {
  Float entry;
  Int sum[4];
};

/// scene::TransferView.
class Function {
 public:
  explicit Function(const scene::TransferView& view) : view_(view) {}

  HWY_INLINE Float entry_of(Float stored) const {
    return hn::Add(hn::Mul(stored, all(view_.to_entry_scale)), all(view_.to_entry_offset));
  }
  HWY_INLINE Float to_entries(Float deviation) const { return hn::Mul(deviation, all(view_.to_entry_scale)); }

  HWY_INLINE Reading read(Float entry) const {
    const Float held = held_in_table(entry);
    const Int low = hn::Min(hn::ConvertTo(kInts, held), all_ints(view_.entries - 2));
    const Float weight = hn::Sub(held, hn::ConvertTo(kFloats, low));
    const Float units = hn::Mul(weight, all(view_.integrals_per_unit));
    alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
    hn::Store(offset_of(low), kInts, offsets);
    Int sum[4], density[4];
    load_rows(sums(), offsets, sum);
    load_rows(densities(), offsets, density);
    Reading reading;
    reading.entry = entry;
    for (int i = 0; i < 4; ++i) {
      const Float more = hn::Mul(units, hn::BitCast(kFloats, density[i]));
      reading.sum[i] = hn::Add(sum[i], hn::ConvertTo(kInts, more));
    }
    return reading;
  }

  /// Lanes whose readings are no more than kNarrow apart mean nothing.
  HWY_INLINE Matter mean(const Reading& a, const Reading& b) const {
    const Float zero = hn::Zero(kFloats), last = all(static_cast<float>(view_.entries - 1));
    const Float width = hn::Sub(b.entry, a.entry);
    const Mask wide = hn::Gt(hn::Abs(width), all(scene::TransferView::kNarrow));
    const Float share = hn::Div(all(1), hn::IfThenElse(wide, width, all(1)));
    const Float scale = hn::Mul(all(view_.integral_unit), share);
    Matter m;
    for (int i = 0; i < 4; ++i) {
      m.part[i] = hn::Mul(scale, hn::ConvertTo(kFloats, hn::Sub(b.sum[i], a.sum[i])));
    }
    if (!none(hn::Or(hn::Lt(hn::Min(a.entry, b.entry), zero), hn::Gt(hn::Max(a.entry, b.entry), last)))) {
      const Float before = hn::Mul(share, hn::Sub(hn::Min(b.entry, zero), hn::Min(a.entry, zero)));
      const Float behind = hn::Mul(share, hn::Sub(hn::Max(b.entry, last), hn::Max(a.entry, last)));
      add(m, before, view_.matter[0]);
      add(m, behind, view_.matter[view_.entries - 1]);
    }
    return m;
  }

  HWY_INLINE Mask is_even(Float from, Float to) const {
    const Float width = hn::Abs(hn::Sub(to, from)), lower = hn::Min(from, to), upper = hn::Max(from, to);
    const Mask inside =
        hn::And(hn::Ge(lower, hn::Zero(kFloats)), hn::Le(upper, all(static_cast<float>(view_.entries - 1))));
    const Float most = hn::IfThenElse(inside, all(view_.even_width_inside), all(view_.even_width));
    return hn::Or(hn::Le(width, most), hn::Ge(lower, all(view_.even_above)));
  }

  HWY_INLINE Matter density_at(Float entry) const {
    alignas(64) std::int32_t offsets[hn::MaxLanes(kInts)];
    hn::Store(offset_of(hn::ConvertTo(kInts, held_in_table(entry))), kInts, offsets);
    Int density[4];
    load_rows(densities(), offsets, density);
    Matter m;
    for (int i = 0; i < 4; ++i) m.part[i] = hn::BitCast(kFloats, density[i]);
    return m;
  }

  HWY_INLINE Mask invisible(Float a, Float b) const {
    return hn::Or(hn::Lt(hn::Max(a, b), all(view_.first_visible)),
                  hn::Gt(hn::Min(a, b), all(view_.last_visible)));
  }

 private:
  HWY_INLINE Float held_in_table(Float entry) const {
    return hn::Min(hn::Max(entry, hn::Zero(kFloats)), all(static_cast<float>(view_.entries - 1)));
  }
  HWY_INLINE static Int offset_of(Int entry) {
    static_assert(sizeof(scene::TransferView::Integral) == 32);
    return hn::ShiftLeft<5>(entry);
  }
  HWY_INLINE const std::byte* sums() const { return reinterpret_cast<const std::byte*>(view_.integral); }
  HWY_INLINE const std::byte* densities() const {
    return sums() + offsetof(scene::TransferView::Integral, density);
  }
  HWY_INLINE static void add(Matter& m, Float weight, const scene::Matter& matter) {
    m.part[0] = hn::MulAdd(weight, all(matter.color.x), m.part[0]);
    m.part[1] = hn::MulAdd(weight, all(matter.color.y), m.part[1]);
    m.part[2] = hn::MulAdd(weight, all(matter.color.z), m.part[2]);
    m.part[3] = hn::MulAdd(weight, all(matter.extinction), m.part[3]);
  }

  const scene::TransferView& view_;
};

/// scene::Shade.
struct Shade {
  Vec3v body, glint;
};

/// The rays of a vector, and what they go through. kPlain: one brick whose voxels deviate from nothing.
template <typename Voxel, bool kPlain>
class Composite {
 public:
  HWY_INLINE Composite(const FrameView& frame, StretchBatch& batch, std::size_t lane)
      : frame_(frame),
        batch_(batch),
        function_(frame.visibility.functions[0]),
        lane_(lane),
        edge_(static_cast<int>(batch.m)),
        fine_first_(load(batch.fine.first, lane)),
        fine_per_step_(load(batch.fine.per_step, lane)),
        color_(load(batch.color, lane)),
        opacity_(hn::Load(kFloats, batch.opacity + lane)) {
    if constexpr (!kPlain) {
      blend_ = hn::Load(kFloats, batch.blend + lane);
      blend_per_step_ = hn::Load(kFloats, batch.blend_per_step + lane);
    }
  }

  HWY_INLINE void run() {
    const Int left = all_ints(static_cast<std::int32_t>(batch_.count - lane_));
    const Int steps =
        hn::IfThenElseZero(hn::Lt(hn::Iota(kInts, 0), left), hn::Load(kInts, batch_.steps + lane_));
    Int samples = hn::Load(kInts, batch_.samples + lane_);
    const auto of_ints = [](Int mask) HWY_ATTR { return hn::Gt(mask, hn::Zero(kInts)); };
    samples = hn::Sub(samples, hn::VecFromMask(kInts, of_ints(steps)));
    Place front = at(all(-0.5f)), back = front;
    Int step = hn::Zero(kInts);
    Mask active = hn::And(hn::RebindMask(kFloats, of_ints(steps)), going());
    Mask found = hn::Lt(opacity_, opacity_);  // lanes before a step in which there is something to see
    // Steps through nothing are cheap: lanes go through theirs until most have found something to see.
    while (!none(active)) {
      Mask searching = hn::AndNot(found, active);
      do {
        back = at(hn::Add(hn::ConvertTo(kFloats, step), all(0.5f)));
        samples = hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, searching)));
        const Mask visible = hn::AndNot(unseen(front, back), searching);
        found = hn::Or(found, visible);
        const Mask passing = hn::AndNot(visible, searching);
        front = select(passing, back, front);
        step = hn::Sub(step, hn::VecFromMask(kInts, hn::RebindMask(kInts, passing)));
        active = hn::And(active, hn::RebindMask(kFloats, hn::Lt(step, steps)));
        searching = hn::And(passing, active);
      } while (!none(searching) &&
               (none(found) || 4 * hn::CountTrue(kFloats, searching) > hn::Lanes(kFloats)));
      if (none(found)) continue;
      composite_step(hn::ConvertTo(kFloats, step), front, back, found, samples);
      front = select(found, back, front);
      step = hn::Sub(step, hn::VecFromMask(kInts, hn::RebindMask(kInts, found)));
      active = hn::And(hn::And(active, going()), hn::RebindMask(kFloats, hn::Lt(step, steps)));
      found = hn::Lt(opacity_, opacity_);
    }
    hn::Store(samples, kInts, batch_.samples + lane_);
    hn::Store(color_.x, kFloats, batch_.color[0] + lane_);
    hn::Store(color_.y, kFloats, batch_.color[1] + lane_);
    hn::Store(color_.z, kFloats, batch_.color[2] + lane_);
    hn::Store(opacity_, kFloats, batch_.opacity + lane_);
  }

 private:
  /// ScalarSample, in entries.
  struct Place {
    Float entry;
    Float deviation;
  };
  HWY_INLINE static Place select(Mask mask, const Place& a, const Place& b) {
    Place place{hn::IfThenElse(mask, a.entry, b.entry), b.deviation};
    if constexpr (!kPlain) place.deviation = hn::IfThenElse(mask, a.deviation, b.deviation);
    return place;
  }

  /// Span.
  struct Span {
    Float centre, begin, length;
    Float from, to, variance3;
    Matter matter;
    Float longest;
  };

  HWY_INLINE Mask going() const { return hn::Lt(opacity_, all(kOpaque)); }

  HWY_INLINE const Voxel* texels(const StretchBatch::Path& path) const {
    return reinterpret_cast<const Voxel*>(path.brick);
  }
  HWY_INLINE const std::uint8_t* deviations(const StretchBatch::Path& path) const {
    return reinterpret_cast<const std::uint8_t*>(texels(path) + plane_texels(batch_.m));
  }
  HWY_INLINE Vec3v coarse_at(Float i) const {
    return along(load(batch_.coarse.first, lane_), load(batch_.coarse.per_step, lane_), i);
  }
  HWY_INLINE Float blend_at(Float i) const {
    return hn::Min(hn::Max(hn::MulAdd(i, blend_per_step_, blend_), hn::Zero(kFloats)), all(1));
  }

  HWY_INLINE Place at(Float i) const {
    const Vec3v p = along(fine_first_, fine_per_step_, i);
    Float value = sample(texels(batch_.fine), edge_, p);
    Place place;
    place.deviation = hn::Zero(kFloats);
    if constexpr (!kPlain) {
      if (batch_.fine.deviates) place.deviation = deviation(deviations(batch_.fine), edge_, p);
      if (batch_.blended) {
        const Vec3v q = coarse_at(i);
        const Float blend = blend_at(i);
        value = mix(value, sample(texels(batch_.coarse), edge_, q), blend);
        place.deviation = mix(place.deviation, deviation(deviations(batch_.coarse), edge_, q), blend);
      }
      place.deviation = function_.to_entries(place.deviation);
    }
    place.entry = function_.entry_of(value);
    return place;
  }

  HWY_INLINE Float spread(Float from, Float to, Float variance3) const {
    const Float width = hn::Sub(to, from);
    return hn::Sqrt(hn::MulAdd(hn::Mul(all(0.25f), width), width, variance3));
  }
  HWY_INLINE Float variance3_of(const Place& a, const Place& b) const {
    const Float deviation = hn::Mul(all(0.5f), hn::Add(a.deviation, b.deviation));
    return hn::Mul(all(3), hn::Mul(deviation, deviation));
  }

  HWY_INLINE Mask unseen(const Place& a, const Place& b) const {
    if constexpr (kPlain) return function_.invisible(a.entry, b.entry);
    const Float centre = hn::Mul(all(0.5f), hn::Add(a.entry, b.entry));
    const Float half = spread(a.entry, b.entry, variance3_of(a, b));
    return function_.invisible(hn::Sub(centre, half), hn::Add(centre, half));
  }

  /// EntryPath::mean between two entries, of the lanes of `mask`.
  HWY_INLINE Matter mean(Float from, Float to, Float variance3, Mask mask) const {
    const Float centre = hn::Mul(all(0.5f), hn::Add(from, to));
    if constexpr (!kPlain) {
      const Float half = spread(from, to, variance3);
      from = hn::Sub(centre, half);
      to = hn::Add(centre, half);
    }
    Matter m;
    for (Float& part : m.part) part = hn::Zero(kFloats);
    mask = hn::AndNot(function_.invisible(from, to), mask);
    if (none(mask)) return m;
    const Mask even = function_.is_even(from, to);
    const bool some_even = !none(hn::And(mask, even)), all_even = none(hn::AndNot(even, mask));
    if (some_even) m = function_.density_at(centre);
    if (!all_even) {
      const Matter wide = function_.mean(function_.read(from), function_.read(to));
      m = some_even ? render::HWY_NAMESPACE::select(even, m, wide) : wide;
    }
    for (Float& part : m.part) part = hn::IfThenElseZero(mask, part);
    return m;
  }

  HWY_INLINE Span span_of(Float centre, Float begin, Float length, const Place& front, const Place& back,
                          Mask mask) const {
    Span span;
    span.centre = centre;
    span.begin = begin;
    span.length = length;
    span.from = front.entry;
    span.to = back.entry;
    span.longest = hn::Abs(hn::Sub(back.entry, front.entry));
    span.variance3 = variance3_of(front, back);
    span.matter = mean(span.from, span.to, span.variance3, mask);
    return span;
  }

  /// A step between two places, of the lanes of `mask`.
  HWY_INLINE void composite_step(Float centre, const Place& front, const Place& back, Mask mask,
                                 Int& samples) {
    const Float units = all(batch_.units), one = all(1);
    const Float begin = hn::Sub(centre, all(0.5f));
    const Span whole = span_of(centre, begin, one, front, back, mask);
    const Float extinction = whole.matter.part[3];
    mask = hn::And(mask, hn::Gt(extinction, hn::Zero(kFloats)));
    if (none(mask)) return;
    const Float opaque = hn::Min(hn::Mul(extinction, units), one);
    const Float wanted =
        hn::Min(hn::MulAdd(hn::Mul(opaque, whole.longest), all(1 / kWidePath), one), all(float(kMostCuts)));
    const Float cuts = hn::Floor(wanted);
    if (none(hn::And(mask, hn::Gt(cuts, one)))) {
      composite_span(whole, units, mask);
      return;
    }
    const Float share = hn::Div(one, cuts);
    Place from = front;
    for (float cut = 1;; cut += 1) {
      mask = hn::And(mask, hn::And(hn::Le(all(cut), cuts), going()));
      if (none(mask)) break;
      const Float end = hn::MulAdd(all(cut), share, begin);
      const Place to = at(end);
      // A step that is not cut ends where it was sampled already.
      samples =
          hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, hn::And(mask, hn::Gt(cuts, one)))));
      const Span span = span_of(centre, hn::Sub(end, share), share, from, to, mask);
      composite_span(span, hn::Mul(units, share),
                     hn::And(mask, hn::Gt(span.matter.part[3], hn::Zero(kFloats))));
      from = to;
    }
  }

  HWY_INLINE void composite_span(const Span& span, Float units, Mask mask) {
    if (none(mask)) return;
    const Float zero = hn::Zero(kFloats), one = all(1);
    const Float most = all(float(kMostParts));
    const Float thin = hn::MulAdd(hn::Mul(span.matter.part[3], units), all(1 / kThinDepth), one);
    const Float parts =
        hn::IfThenElse(hn::Gt(span.longest, all(kNarrowPath)), hn::Floor(hn::Min(thin, most)), one);
    const Mask parted = hn::Gt(parts, one);
    const Float share = hn::Div(one, parts);
    Matter matter[kMostParts];
    Float opacity[kMostParts];
    Float seen_at = all(0.5f);
    int count = 1;
    if (none(hn::And(mask, parted))) {
      matter[0] = span.matter;
      opacity[0] = opacity_of(hn::Mul(span.matter.part[3], units));
    } else {
      count = static_cast<int>(hn::GetLane(hn::MaxOfLanes(kFloats, hn::IfThenElseZero(mask, parts))));
      const Float length = hn::Mul(hn::Sub(span.to, span.from), share);
      const Float depth = hn::Mul(units, share);
      Float left = one, moment = zero;
      for (int part = 0; part < count; ++part) {
        const Float number = all(static_cast<float>(part));
        const Float to = hn::MulAdd(hn::Add(number, one), length, span.from);
        const Matter here = mean(hn::Sub(to, length), to, span.variance3, hn::And(mask, parted));
        matter[part] = render::HWY_NAMESPACE::select(parted, here, span.matter);
        const Float seen = opacity_of(hn::Mul(matter[part].part[3], depth));
        opacity[part] = hn::IfThenElseZero(hn::Lt(number, parts), seen);
        const Float middle = hn::Mul(hn::Add(number, all(0.5f)), share);
        moment = hn::MulAdd(hn::Mul(left, opacity[part]), middle, moment);
        left = hn::Mul(left, hn::Sub(one, opacity[part]));
      }
      const Mask moved = hn::And(parted, hn::Lt(left, one));
      seen_at =
          hn::IfThenElse(moved, hn::Div(moment, hn::Sub(one, hn::IfThenElseZero(moved, left))), seen_at);
    }
    Shade shade{{one, one, one}, {zero, zero, zero}};
    const bool lit = frame_.lighting.lighting.enabled;
    if (lit) shade = shade_at(held_in_voxel(span.centre, hn::MulAdd(seen_at, span.length, span.begin)));
    for (int part = 0; part < count; ++part) {
      const Matter& m = matter[part];
      // Lanes of no concern may hold anything: they are kept out by selection, not by a weight of 0.
      const Mask seen =
          hn::And(hn::And(mask, going()), hn::And(hn::Gt(m.part[3], zero), hn::Gt(opacity[part], zero)));
      if (none(seen)) continue;
      const Float weight = hn::Mul(hn::Sub(one, opacity_), opacity[part]);
      const Float of_color = hn::Div(weight, hn::IfThenElse(seen, m.part[3], one));
      color_.x = gather_color(seen, color_.x, m.part[0], of_color, weight, shade.body.x, shade.glint.x, lit);
      color_.y = gather_color(seen, color_.y, m.part[1], of_color, weight, shade.body.y, shade.glint.y, lit);
      color_.z = gather_color(seen, color_.z, m.part[2], of_color, weight, shade.body.z, shade.glint.z, lit);
      opacity_ = hn::IfThenElse(seen, hn::Add(opacity_, weight), opacity_);
    }
  }

  HWY_INLINE static Float gather_color(Mask seen, Float sum, Float color, Float of_color, Float weight,
                                       Float body, Float glint, bool lit) {
    const Float more = lit ? hn::MulAdd(weight, glint, hn::MulAdd(hn::Mul(of_color, color), body, sum))
                           : hn::MulAdd(of_color, color, sum);
    return hn::IfThenElse(seen, more, sum);
  }

  /// Stretch::held_in_voxel.
  HWY_INLINE Float held_in_voxel(Float centre, Float i) const {
    const Vec3v from = along(fine_first_, fine_per_step_, centre);
    const Float way = hn::Sub(i, centre);
    Float share = all(1);
    share = hn::Min(share, share_to_face(from.x, hn::Mul(way, fine_per_step_.x)));
    share = hn::Min(share, share_to_face(from.y, hn::Mul(way, fine_per_step_.y)));
    share = hn::Min(share, share_to_face(from.z, hn::Mul(way, fine_per_step_.z)));
    return hn::MulAdd(share, way, centre);
  }
  HWY_INLINE static Float share_to_face(Float from, Float way) {
    const Float zero = hn::Zero(kFloats), one = all(1);
    const Float low = hn::Floor(from);
    const Float to_face = hn::Sub(hn::IfThenElse(hn::Gt(way, zero), hn::Add(low, one), low), from);
    const Mask still = hn::Eq(way, zero);
    return hn::IfThenElse(still, one, hn::Div(to_face, hn::IfThenElse(still, one, way)));
  }

  /// RayView::shade at place i.
  HWY_INLINE Shade shade_at(Float i) const {
    Vec3v g = gradient(texels(batch_.fine), edge_, along(fine_first_, fine_per_step_, i));
    Float scale = all(batch_.fine.gradient_scale);
    if constexpr (!kPlain) {
      if (batch_.blended) {
        const Float blend = blend_at(i);
        const Vec3v coarse = gradient(texels(batch_.coarse), edge_, coarse_at(i));
        g = {mix(g.x, coarse.x, blend), mix(g.y, coarse.y, blend), mix(g.z, coarse.z, blend)};
        scale = mix(scale, all(batch_.coarse.gradient_scale), blend);
      }
    }
    const Float zero = hn::Zero(kFloats), one = all(1);
    const Float soft = all(frame_.soft_gradient[0]);
    const Float steep2 = hn::Mul(hn::Mul(scale, scale), dot(g, g));
    const Float certainty = hn::Div(steep2, hn::MulAdd(soft, soft, steep2));
    const Vec3v world = {to_world(0, g), to_world(1, g), to_world(2, g)};
    const Float steepness = hn::Sqrt(dot(world, world));
    const Mask has_normal = hn::Gt(steepness, zero);
    const Float inverse = hn::Div(one, hn::IfThenElse(has_normal, steepness, one));
    const Vec3v normal = {hn::Mul(world.x, inverse), hn::Mul(world.y, inverse), hn::Mul(world.z, inverse)};
    const scene::Lighting& lighting = frame_.lighting.lighting;
    const Vec3v to_eye = load(batch_.to_eye, lane_);
    const Float ambient = all(lighting.ambient);
    Shade shade{{ambient, ambient, ambient}, {zero, zero, zero}};
    for (int l = 0; l < lighting.lights; ++l) {
      const scene::Light& light = lighting.light[l];
      const Vec3f place(frame_.lighting.place[l]);
      Vec3v to_light = {all(place.x), all(place.y), all(place.z)};
      if (light.kind == scene::LightKind::point) {
        const Vec3v point = along(load(batch_.place, lane_), load(batch_.place_per_step, lane_), i);
        to_light = unit_or_zero(
            {hn::Sub(to_light.x, point.x), hn::Sub(to_light.y, point.y), hn::Sub(to_light.z, point.z)});
      }
      const Float turned = hn::Sub(hn::Abs(dot(normal, to_light)), one);
      const Float facing = hn::IfThenElse(has_normal, hn::MulAdd(certainty, turned, one), one);
      const Vec3v between = unit_or_zero(
          {hn::Add(to_eye.x, to_light.x), hn::Add(to_eye.y, to_light.y), hn::Add(to_eye.z, to_light.z)});
      const Float half = hn::Abs(dot(normal, between));
      const Float power = power_of(half, lighting.shininess);
      const Float glint =
          hn::IfThenElseZero(has_normal, hn::Mul(hn::Mul(certainty, all(lighting.specular)), power));
      const Float diffuse = hn::Mul(all(lighting.diffuse), facing);
      const Float r = all(light.color.x), gr = all(light.color.y), b = all(light.color.z);
      shade.body = {hn::MulAdd(diffuse, r, shade.body.x), hn::MulAdd(diffuse, gr, shade.body.y),
                    hn::MulAdd(diffuse, b, shade.body.z)};
      shade.glint = {hn::MulAdd(glint, r, shade.glint.x), hn::MulAdd(glint, gr, shade.glint.y),
                     hn::MulAdd(glint, b, shade.glint.z)};
    }
    return shade;
  }

  HWY_INLINE Float to_world(int axis, const Vec3v& g) const {
    const Vec3f column(frame_.world_to_tree.column[axis]);
    return dot({all(column.x), all(column.y), all(column.z)}, g);
  }
  HWY_INLINE static Vec3v unit_or_zero(const Vec3v& v) {
    const Float length2 = dot(v, v);
    const Mask some = hn::Gt(length2, hn::Zero(kFloats));
    const Float inverse =
        hn::IfThenElseZero(some, hn::Div(all(1), hn::Sqrt(hn::IfThenElse(some, length2, all(1)))));
    return {hn::Mul(v.x, inverse), hn::Mul(v.y, inverse), hn::Mul(v.z, inverse)};
  }
  HWY_INLINE static Float power_of(Float base, float exponent) {
    if (exponent == 0) return all(1);
    constexpr float kLeast = 1e-30f;  // the logarithm of nothing would be none
    return hn::Exp(kFloats, hn::Mul(all(exponent), hn::Log(kFloats, hn::Max(base, all(kLeast)))));
  }

  const FrameView& frame_;
  StretchBatch& batch_;
  const Function function_;
  const std::size_t lane_;
  const int edge_;
  const Vec3v fine_first_, fine_per_step_;
  Float blend_, blend_per_step_;
  Vec3v color_;
  Float opacity_;
};

template <typename Voxel>
void composite_all(const FrameView& frame, StretchBatch& batch) {
  const bool plain = !batch.blended && !batch.fine.deviates;
  for (std::size_t lane = 0; lane < batch.count; lane += hn::Lanes(kFloats)) {
    if (plain) {
      Composite<Voxel, true>(frame, batch, lane).run();
    } else {
      Composite<Voxel, false>(frame, batch, lane).run();
    }
  }
}

}  // namespace

void composite_u8(const FrameView& frame, StretchBatch& batch) {
  composite_all<std::uint8_t>(frame, batch);
}
void composite_u16(const FrameView& frame, StretchBatch& batch) {
  composite_all<std::uint16_t>(frame, batch);
}
void composite_f32(const FrameView& frame, StretchBatch& batch) {
  composite_all<float>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(composite_u8);
HWY_EXPORT(composite_u16);
HWY_EXPORT(composite_f32);

bool composites_batches(const FrameView& frame) {
  const scene::Visibility& visibility = frame.visibility;
  return frame.format.content == VoxelContent::scalar && visibility.mode == scene::Mode::composite &&
         visibility.channels == 1 && visibility.functions[0].gradient_factor == nullptr;
}

void composite_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.type) {
    case VoxelType::u8:
      return HWY_DYNAMIC_DISPATCH(composite_u8)(frame, batch);
    case VoxelType::u16:
      return HWY_DYNAMIC_DISPATCH(composite_u16)(frame, batch);
    case VoxelType::f32:
      return HWY_DYNAMIC_DISPATCH(composite_f32)(frame, batch);
  }
}

}  // namespace gvx::render
#endif
