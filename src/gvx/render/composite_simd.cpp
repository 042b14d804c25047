// composite_batch: composite.h once more, with a ray in each lane of a vector. What is said there holds here;
// the same names mean the same. Compiled once for each instruction set.

#include <type_traits>

#include "gvx/render/composite.h"
#include "gvx/render/simd_targets.h"
#include "gvx/render/stretch_batch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/composite_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include <hwy/contrib/math/math-inl.h>
#include "gvx/render/sample_simd-inl.h"
#include "gvx/render/shade_simd-inl.h"
#include "gvx/render/transfer_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

HWY_INLINE Float opacity_of(Float depth) {
  return hn::Sub(all(1), hn::Exp(kFloats, hn::Neg(depth)));
}

/// The rays of a vector, and what they go through. kPlain: one brick whose voxels deviate from nothing.
template <typename Voxel, bool kPlain>
class Composite {
 public:
  HWY_INLINE Composite(const FrameView& frame, StretchBatch& batch, std::size_t lane)
      : frame_(frame),
        batch_(batch),
        function_(frame.visibility.functions[0]),
        lanes_(batch, lane),
        edge_(static_cast<int>(batch.m)),
        fine_(lanes_.fine(batch)),
        coarse_(!kPlain && batch.blended ? lanes_.coarse(batch) : fine_),
        to_eye_(frame.lighting.lighting.enabled ? lanes_.to_eye(batch) : fine_.first),
        by_gradient_(frame.visibility.functions[0].gradient_factor != nullptr) {
    lanes_.load(batch, color_, opacity_);
    if (frame.lighting.lighting.enabled) halfways_.find(frame.lighting, to_eye_);
  }

  HWY_INLINE void run() {
    const Int steps = hn::ConvertTo(kInts, lanes_.steps(fine_));
    Int samples = hn::Zero(kInts);
    const auto of_ints = [](Int mask) HWY_ATTR { return hn::Gt(mask, hn::Zero(kInts)); };
    samples = hn::Sub(samples, hn::VecFromMask(kInts, of_ints(steps)));
    Mask active = hn::And(hn::RebindMask(kFloats, of_ints(steps)), going());
    const bool all_cells = !kPlain || batch_.cells == ~std::uint64_t(0);
    const Float begin = all(-0.5f);
    Place front = below();
    const Mask begun = all_cells ? active : hn::And(active, may_be_seen(begin));
    if (!none(begun)) front = select(begun, at(begin), front);
    Place back = front;
    Int step = hn::Zero(kInts);
    Mask found = no_lanes();  // those before a step in which there is something to see
    // Steps through nothing are cheap: lanes go through theirs until most have found something to see.
    while (!none(active)) {
      Mask searching = hn::AndNot(found, active);
      do {
        const Float end = hn::Add(hn::ConvertTo(kFloats, step), all(0.5f));
        const Mask sampled =
            all_cells ? searching
                      : hn::And(searching, hn::Or(function_.above_first(front.entry), may_be_seen(end)));
        // Whoever is beside it: a lane that need not be sampled is below.
        if (!none(sampled)) {
          back = select(hn::Or(found, sampled), at(end), below());
        } else {
          back = select(found, back, below());
        }
        samples = hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, sampled)));
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
      const Mask unknown = hn::And(found, hn::Lt(front.entry, all(0.1f * kBelow)));
      if (!all_cells && !none(unknown)) {
        front = select(unknown, at(hn::Sub(hn::ConvertTo(kFloats, step), all(0.5f))), front);
      }
      composite_step(hn::ConvertTo(kFloats, step), front, back, found, samples);
      front = select(found, back, front);
      step = hn::Sub(step, hn::VecFromMask(kInts, hn::RebindMask(kInts, found)));
      active = hn::And(hn::And(active, going()), hn::RebindMask(kFloats, hn::Lt(step, steps)));
      found = no_lanes();
    }
    lanes_.store(batch_, color_, opacity_, samples);
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

  /// Somewhere below all that is seen: where the cells' masks say so, nothing is sampled.
  static constexpr float kBelow = -1e30f;
  HWY_INLINE static Place below() { return {all(kBelow), hn::Zero(kFloats)}; }
  HWY_INLINE Mask may_be_seen(Float i) const { return in_visible_cell(batch_.cells, edge_, fine_.at(i)); }

  /// Span.
  struct Span {
    Float centre, begin, length;
    Float from, to, variance3;
    Matter matter;
    Float longest;
  };

  HWY_INLINE static Mask no_lanes() { return hn::Lt(all(1), all(0)); }
  HWY_INLINE Mask going() const { return hn::Lt(opacity_, all(kOpaque)); }

  HWY_INLINE const Voxel* texels(const StretchBatch::Path& path) const {
    return reinterpret_cast<const Voxel*>(path.brick);
  }
  HWY_INLINE const std::uint8_t* deviations(const StretchBatch::Path& path) const {
    return reinterpret_cast<const std::uint8_t*>(texels(path) + plane_texels(batch_.m));
  }
  HWY_INLINE Float blend_at(Float i) const {
    return hn::Min(hn::Max(hn::MulAdd(i, coarse_.eighth, coarse_.fourth), hn::Zero(kFloats)), all(1));
  }

  GVX_PIECE Place at(Float i) const {
    const Vec3v p = fine_.at(i);
    const PlainTexels<Voxel> plain(batch_.fine.brick);
    Float value;
    if constexpr (kPlain && std::is_same_v<Voxel, std::uint8_t>) {
      value = batch_.has_quads ? sample(QuadTexels{batch_.quads}, edge_, p) : sample(plain, edge_, p);
    } else {
      value = sample(plain, edge_, p);
    }
    Place place;
    place.deviation = hn::Zero(kFloats);
    if constexpr (!kPlain) {
      if (batch_.fine.deviates) place.deviation = deviation(deviations(batch_.fine), edge_, p);
      if (batch_.blended) {
        const Vec3v q = coarse_.at(i);
        const Float blend = blend_at(i);
        value = mix(value, sample(PlainTexels<Voxel>(batch_.coarse.brick), edge_, q), blend);
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
  GVX_PIECE Matter mean(Float from, Float to, Float variance3, Mask mask) const {
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

  GVX_PIECE Span span_of(Float centre, Float begin, Float length, const Place& front, const Place& back,
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
  GVX_PIECE void composite_step(Float centre, const Place& front, const Place& back, Mask mask,
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

  GVX_PIECE void composite_span(const Span& span, Float units, Mask mask) {
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
    Shade light{{one, one, one}, {zero, zero, zero}};
    const bool lit = frame_.lighting.lighting.enabled;
    if (lit || by_gradient_) {
      const Float at = held_in_voxel(fine_, span.centre, hn::MulAdd(seen_at, span.length, span.begin));
      const Slope slope = slope_at(at);
      if (lit) light = shade_at(at, slope);
      if (by_gradient_) {
        const Float depth = hn::Mul(hn::Mul(units, share), factor_of(slope));
        for (int part = 0; part < count; ++part) {
          const Float seen = opacity_of(hn::Mul(matter[part].part[3], depth));
          opacity[part] = hn::IfThenElseZero(hn::Lt(all(static_cast<float>(part)), parts), seen);
        }
      }
    }
    for (int part = 0; part < count; ++part) {
      const Matter& m = matter[part];
      // Lanes of no concern may hold anything: they are kept out by selection, not by a weight of 0.
      const Mask seen =
          hn::And(hn::And(mask, going()), hn::And(hn::Gt(m.part[3], zero), hn::Gt(opacity[part], zero)));
      if (none(seen)) continue;
      const Float weight = hn::Mul(hn::Sub(one, opacity_), opacity[part]);
      const Float of_color = hn::Div(weight, hn::IfThenElse(seen, m.part[3], one));
      color_.x = gather_color(seen, color_.x, m.part[0], of_color, weight, light.body.x, light.glint.x, lit);
      color_.y = gather_color(seen, color_.y, m.part[1], of_color, weight, light.body.y, light.glint.y, lit);
      color_.z = gather_color(seen, color_.z, m.part[2], of_color, weight, light.body.z, light.glint.z, lit);
      opacity_ = hn::IfThenElse(seen, hn::Add(opacity_, weight), opacity_);
    }
  }

  HWY_INLINE static Float gather_color(Mask seen, Float sum, Float color, Float of_color, Float weight,
                                       Float body, Float glint, bool lit) {
    const Float more = lit ? hn::MulAdd(weight, glint, hn::MulAdd(hn::Mul(of_color, color), body, sum))
                           : hn::MulAdd(of_color, color, sum);
    return hn::IfThenElse(seen, more, sum);
  }

  /// The gradient, in stored values a voxel of the levels that are blended.
  struct Slope {
    Vec3v gradient;
    Float blend;
  };
  HWY_NOINLINE Slope slope_at(Float i) const {
    Slope slope{gradient(texels(batch_.fine), edge_, fine_.at(i)), hn::Zero(kFloats)};
    if constexpr (!kPlain) {
      if (batch_.blended) {
        slope.blend = blend_at(i);
        const Vec3v coarse = gradient(texels(batch_.coarse), edge_, coarse_.at(i));
        Vec3v& g = slope.gradient;
        g = {mix(g.x, coarse.x, slope.blend), mix(g.y, coarse.y, slope.blend),
             mix(g.z, coarse.z, slope.blend)};
      }
    }
    return slope;
  }

  /// RayView::shade at place i.
  HWY_NOINLINE Shade shade_at(Float i, const Slope& slope) const {
    Float scale = all(batch_.fine.gradient_scale);
    if constexpr (!kPlain) {
      if (batch_.blended) scale = mix(scale, all(batch_.coarse.gradient_scale), slope.blend);
    }
    return shade(frame_, scaled(all(1 / frame_.soft_gradient[0]), slope.gradient), scale, to_eye_, halfways_,
                 [&]() HWY_ATTR { return lanes_.places(batch_).at(i); });
  }

  /// TransferView::factor_of_gradient.
  HWY_NOINLINE Float factor_of(const Slope& slope) const {
    Float voxels = all(batch_.fine.voxels_across);
    if constexpr (!kPlain) {
      if (batch_.blended) voxels = mix(voxels, all(batch_.coarse.voxels_across), slope.blend);
    }
    const Vec3v world = to_world(frame_, slope.gradient);
    return function_.factor_of_gradient(hn::Mul(hn::Sqrt(dot(world, world)), voxels));
  }

  const FrameView& frame_;
  StretchBatch& batch_;
  const Function function_;
  const BatchLanes lanes_;
  const int edge_;
  const PathRows fine_, coarse_;
  const Vec3v to_eye_;
  const bool by_gradient_;
  Halfways halfways_;
  Vec3v color_;
  Float opacity_;
};

template <typename Voxel>
void composite_all(const FrameView& frame, StretchBatch& batch) {
  const bool plain = !batch.blended && !batch.fine.deviates;
  batch.has_quads = false;
  batch.opaque_count = 0;
  if constexpr (std::is_same_v<Voxel, std::uint8_t>) batch.has_quads = plain && makes_quads(batch);
  for (std::size_t lane = 0; lane < batch.count; lane += hn::Lanes(kFloats)) {
    if (plain) {
      Composite<Voxel, true>(frame, batch, lane).run();
    } else {
      Composite<Voxel, false>(frame, batch, lane).run();
    }
  }
}

}  // namespace

const char* name_of_set() {
  return hwy::TargetName(HWY_TARGET);
}
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

HWY_EXPORT(name_of_set);
HWY_EXPORT(composite_u8);
HWY_EXPORT(composite_u16);
HWY_EXPORT(composite_f32);

bool composites_batches(const FrameView& frame) {
  const scene::Visibility& visibility = frame.visibility;
  return frame.format.content == VoxelContent::scalar && visibility.mode == scene::Mode::composite &&
         visibility.channels == 1 &&
         (frame.classification == scene::Classification::preintegrated || frame.step_colors != nullptr);
}

const char* instruction_set() {
  return HWY_DYNAMIC_DISPATCH(name_of_set)();
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
