// composite_batch: composite.h once more, with a ray in each lane of a vector. What is said there holds here;
// the same names mean the same. Compiled once for each instruction set.

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

template <typename Voxel>
HWY_INLINE Vec3v gradient(const Voxel* texels, int edge, const Vec3v& p) {
  const Float half = all(0.5f);
  const TexelAxis x(p.x, edge), y(p.y, edge), z(p.z, edge);
  const TexelAxis x0(hn::Sub(p.x, half), edge), x1(hn::Add(p.x, half), edge);
  const TexelAxis y0(hn::Sub(p.y, half), edge), y1(hn::Add(p.y, half), edge);
  const TexelAxis z0(hn::Sub(p.z, half), edge), z1(hn::Add(p.z, half), edge);
  return {hn::Sub(trilinear(texels, edge, x1, y, z), trilinear(texels, edge, x0, y, z)),
          hn::Sub(trilinear(texels, edge, x, y1, z), trilinear(texels, edge, x, y0, z)),
          hn::Sub(trilinear(texels, edge, x, y, z1), trilinear(texels, edge, x, y, z0))};
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

/// scene::TransferView::Reading.
struct Reading {
  Float entry;
  Int sum[4];
  Float density[4];
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
    const auto* table = reinterpret_cast<const std::int32_t*>(view_.integral);
    const Float held = hn::Min(hn::Max(entry, hn::Zero(kFloats)), all(static_cast<float>(view_.entries - 1)));
    const Int low = hn::Min(hn::ConvertTo(kInts, held), all_ints(view_.entries - 2));
    const Float weight = hn::Sub(held, hn::ConvertTo(kFloats, low));
    const Float units = hn::Mul(weight, all(view_.integrals_per_unit));
    static_assert(sizeof(scene::TransferView::Integral) == 32);
    const Int offset = hn::ShiftLeft<5>(low);
    Reading reading;
    reading.entry = entry;
    for (int i = 0; i < 4; ++i) {
      const Int sum = hn::GatherOffset(kInts, table + i, offset);
      reading.density[i] = hn::GatherOffset(kFloats, reinterpret_cast<const float*>(table + 4 + i), offset);
      reading.sum[i] = hn::Add(sum, hn::ConvertTo(kInts, hn::Mul(units, reading.density[i])));
    }
    return reading;
  }

  HWY_INLINE Matter mean(const Reading& a, const Reading& b) const {
    const Float zero = hn::Zero(kFloats), last = all(static_cast<float>(view_.entries - 1));
    const Float width = hn::Sub(b.entry, a.entry);
    const Mask wide = hn::Gt(hn::Abs(width), all(scene::TransferView::kNarrow));
    const Float share = hn::Div(all(1), hn::IfThenElse(wide, width, all(1)));
    const Float scale = hn::Mul(all(view_.integral_unit), share);
    const Float before = hn::Mul(share, hn::Sub(hn::Min(b.entry, zero), hn::Min(a.entry, zero)));
    const Float behind = hn::Mul(share, hn::Sub(hn::Max(b.entry, last), hn::Max(a.entry, last)));
    const scene::Matter &first_matter = view_.matter[0], &last_matter = view_.matter[view_.entries - 1];
    const float first_parts[4] = {first_matter.color.x, first_matter.color.y, first_matter.color.z,
                                  first_matter.extinction};
    const float last_parts[4] = {last_matter.color.x, last_matter.color.y, last_matter.color.z,
                                 last_matter.extinction};
    Matter m;
    for (int i = 0; i < 4; ++i) {
      Float sum = hn::Mul(scale, hn::ConvertTo(kFloats, hn::Sub(b.sum[i], a.sum[i])));
      sum = hn::MulAdd(before, all(first_parts[i]), sum);
      sum = hn::MulAdd(behind, all(last_parts[i]), sum);
      m.part[i] = hn::IfThenElse(wide, sum, hn::Mul(all(0.5f), hn::Add(a.density[i], b.density[i])));
    }
    return m;
  }

  HWY_INLINE Mask invisible(Float a, Float b) const {
    return hn::Or(hn::Lt(hn::Max(a, b), all(view_.first_visible)),
                  hn::Gt(hn::Min(a, b), all(view_.last_visible)));
  }

 private:
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
    Place front = at(all(-0.5f));
    samples = hn::Sub(samples, hn::VecFromMask(kInts, hn::Gt(steps, hn::Zero(kInts))));
    for (std::int32_t step = 0;; ++step) {
      const Mask active = hn::And(hn::RebindMask(kFloats, hn::Gt(steps, all_ints(step))), going());
      if (none(active)) break;
      const float centre = static_cast<float>(step);
      Place back = at(all(centre + 0.5f));
      samples = hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, active)));
      const Mask visible = hn::And(active, hn::Not(unseen(front, back)));
      if (!none(visible)) {
        read(front);
        read(back);
        composite_step(all(centre), front, back, visible, samples);
      }
      front = back;
    }
    hn::Store(samples, kInts, batch_.samples + lane_);
    hn::Store(color_.x, kFloats, batch_.color[0] + lane_);
    hn::Store(color_.y, kFloats, batch_.color[1] + lane_);
    hn::Store(color_.z, kFloats, batch_.color[2] + lane_);
    hn::Store(opacity_, kFloats, batch_.opacity + lane_);
  }

 private:
  /// Classified.
  struct Place {
    Float entry;
    Float deviation;
    Reading reading;
    bool is_read = false;
  };

  /// Span.
  struct Span {
    Float centre, begin, length;
    Reading front, back;  // plain
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

  HWY_INLINE void read(Place& place) const {
    if (!kPlain || place.is_read) return;
    place.reading = function_.read(place.entry);
    place.is_read = true;
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

  HWY_INLINE Matter spread_mean(Float from, Float to, Float variance3) const {
    const Float centre = hn::Mul(all(0.5f), hn::Add(from, to));
    const Float half = spread(from, to, variance3);
    return function_.mean(function_.read(hn::Sub(centre, half)), function_.read(hn::Add(centre, half)));
  }

  HWY_INLINE Span span_of(Float centre, Float begin, Float length, const Place& front,
                          const Place& back) const {
    Span span;
    span.centre = centre;
    span.begin = begin;
    span.length = length;
    span.from = front.entry;
    span.to = back.entry;
    span.longest = hn::Abs(hn::Sub(back.entry, front.entry));
    if constexpr (kPlain) {
      span.front = front.reading;
      span.back = back.reading;
      span.matter = function_.mean(span.front, span.back);
    } else {
      span.variance3 = variance3_of(front, back);
      span.matter = spread_mean(span.from, span.to, span.variance3);
    }
    return span;
  }

  /// A step between two places that are read, of the lanes of `mask`.
  HWY_INLINE void composite_step(Float centre, const Place& front, const Place& back, Mask mask,
                                 Int& samples) {
    const Float units = all(batch_.units), one = all(1);
    const Float begin = hn::Sub(centre, all(0.5f));
    const Span whole = span_of(centre, begin, one, front, back);
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
      Place to = at(end);
      // A step that is not cut ends where it was sampled already.
      samples =
          hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, hn::And(mask, hn::Gt(cuts, one)))));
      read(to);
      const Span span = span_of(centre, hn::Sub(end, share), share, from, to);
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
      Reading low;
      if constexpr (kPlain) low = span.front;
      Float left = one, moment = zero;
      for (int part = 0; part < count; ++part) {
        const Float number = all(static_cast<float>(part));
        const Float to = hn::MulAdd(hn::Add(number, one), length, span.from);
        Matter here;
        if constexpr (kPlain) {
          const Reading high = function_.read(to);
          here = function_.mean(low, high);
          low = high;
        } else {
          here = spread_mean(hn::Sub(to, length), to, span.variance3);
        }
        matter[part] = select(parted, here, span.matter);
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
      const Mask seen = hn::And(hn::And(mask, going()), hn::Gt(m.part[3], zero));
      const Float weight = hn::IfThenElseZero(hn::And(seen, hn::Gt(opacity[part], zero)),
                                              hn::Mul(hn::Sub(one, opacity_), opacity[part]));
      const Float of_color = hn::Div(weight, hn::IfThenElse(seen, m.part[3], one));
      color_.x = gather_color(color_.x, m.part[0], of_color, weight, shade.body.x, shade.glint.x, lit);
      color_.y = gather_color(color_.y, m.part[1], of_color, weight, shade.body.y, shade.glint.y, lit);
      color_.z = gather_color(color_.z, m.part[2], of_color, weight, shade.body.z, shade.glint.z, lit);
      opacity_ = hn::Add(opacity_, weight);
    }
  }

  HWY_INLINE static Float gather_color(Float sum, Float color, Float of_color, Float weight, Float body,
                                       Float glint, bool lit) {
    if (!lit) return hn::MulAdd(of_color, color, sum);
    return hn::MulAdd(weight, glint, hn::MulAdd(hn::Mul(of_color, color), body, sum));
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
