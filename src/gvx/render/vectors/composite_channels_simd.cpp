// composite_channels_batch: composite.h once more, of several channels, with a ray in each lane of a vector.
// What is said there holds here; the same names mean the same. Compiled once for each instruction set.

#include <type_traits>

#include "gvx/render/reference/composite.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gvx/render/vectors/composite_channels_simd.cpp"
// The order matters.
// clang-format off
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "gvx/render/vectors/composite_rays_simd-inl.h"
#include "gvx/render/vectors/each_step_simd-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// A place of each channel.
struct Places {
  EntrySample channel[kMaxChannels];
};

/// The rays of a vector on their way through a brick.
template <typename Voxel>
class Channels {
 public:
  static constexpr bool kWhole = std::is_integral_v<Voxel>, kLacks = kMayLack<Voxel>;

  HWY_INLINE Channels(const FrameView& frame, const Shading<kWhole>& lights, StretchBatch& batch,
                      std::size_t lane)
      : visibility_(frame.visibility),
        channels_(visibility_.channels),
        planes_(frame.format.planes),
        batch_(batch),
        lanes_(batch, lane),
        rays_(lights, batch, lanes_),
        edge_(static_cast<int>(batch.m)),
        functions_{Function(visibility_.functions[0]), Function(visibility_.functions[1]),
                   Function(visibility_.functions[2]), Function(visibility_.functions[3])} {
    static_assert(kMaxChannels == 4);
    for (std::uint32_t c = 0; c < channels_; ++c) by_gradient_ = by_gradient_ || functions_[c].by_gradient();
    lanes_.load(batch, color_, opacity_);
  }

  HWY_INLINE void run() {
    const Float end = lanes_.steps(rays_.fine);
    const float last = hn::GetLane(hn::MaxOfLanes(kFloats, end));
    Places front, back;
    sample(all(-0.5f), hn::And(hn::Lt(hn::Zero(kFloats), end), going()), front);
    for (float step = 0; step < last; step += 1) {
      const Mask active = hn::And(hn::Lt(all(step), end), going());
      if (none(active)) break;
      sample(all(step + 0.5f), active, back);
      see_step(step, front, back, active);
      front = back;
    }
    lanes_.store(batch_, color_, opacity_, samples_);
  }

 private:
  using Path = StretchBatch::Path;
  using Means = HWY_NAMESPACE::Means<false, kLacks>;

  struct Span {
    Float begin, end;  // in steps
    Float variance3[kMaxChannels];
    Matter matter[kMaxChannels];
    Float extinction, longest;
  };

  /// What is seen of a span, and of which channel, before it is lit.
  struct SeenOf {
    Vec3v color[kMaxChannels];
    Float weight[kMaxChannels];
    Float total, moment;
  };

  struct Slopes {
    Vec3v gradient[kMaxChannels];
    Float blend;
  };

  /// Those lanes of `mask` in which both are data.
  HWY_INLINE static Mask of_data(const EntrySample& a, const EntrySample& b, Mask mask) {
    return kLacks ? hn::AndNot(lack(a, b), mask) : mask;
  }

  HWY_INLINE Mask going() const { return hn::Lt(opacity_, all(kOpaque)); }
  HWY_INLINE Float left() const { return hn::Sub(all(1), opacity_); }

  HWY_INLINE PlainTexels<Voxel> texels(const Path& path, std::uint32_t channel) const {
    return PlainTexels<Voxel>(path.brick + channel * plane_texels(batch_.m) * sizeof(Voxel), edge_);
  }
  HWY_INLINE Float deviation_at(const Path& path, std::uint32_t channel, const Vec3v& p) const {
    const std::byte* first = path.brick + planes_ * plane_texels(batch_.m) * sizeof(Voxel);
    const std::byte* deviations = first + channel * deviation_bytes(static_cast<std::size_t>(edge_));
    const PlainDeviations plane(reinterpret_cast<const std::uint8_t*>(deviations), edge_);
    return plane.some() ? plane.at(PlacesInside(edge_).held(in_texels(p))) : hn::Zero(kFloats);
  }
  HWY_INLINE Float blend_at(Float i) const {
    return batch_.blended ? share_at(rays_.coarse, i) : hn::Zero(kFloats);
  }

  /// sample_at of all channels.
  HWY_NOINLINE void sample(Float i, Mask counted, Places& places) {
    const Vec3v p = rays_.fine.at(i), q = rays_.coarse.at(i);
    const Float blend = blend_at(i);
    for (std::uint32_t c = 0; c < channels_; ++c) {
      Float value = HWY_NAMESPACE::sample(texels(batch_.fine, c), edge_, p), deviates = hn::Zero(kFloats);
      if (batch_.fine.deviates) deviates = deviation_at(batch_.fine, c, p);
      if (batch_.blended) {
        value = blended<kLacks>(value, HWY_NAMESPACE::sample(texels(batch_.coarse, c), edge_, q), blend);
        deviates = mix(deviates, deviation_at(batch_.coarse, c, q), blend);
      }
      places.channel[c] = {entry_or_none<kLacks>(functions_[c].entry_of(value)),
                           functions_[c].to_entries(deviates)};
    }
    samples_ = hn::Sub(samples_, hn::VecFromMask(kInts, hn::RebindMask(kInts, counted)));
  }

  GVX_PIECE Span span_of(const Places& from, const Places& to, Float begin, Float end, Mask mask) const {
    Span span;
    span.begin = begin;
    span.end = end;
    span.extinction = span.longest = hn::Zero(kFloats);
    for (std::uint32_t c = 0; c < channels_; ++c) {
      const EntrySample &a = from.channel[c], &b = to.channel[c];
      const Mask has = of_data(a, b, mask);
      span.variance3[c] = Means::variance3(a, b);
      span.matter[c] = Means(functions_[c]).mean(a.entry, b.entry, span.variance3[c], has);
      span.extinction = hn::Add(span.extinction, span.matter[c].part[3]);
      const Float length = functions_[c].length(a.entry, b.entry);
      span.longest = hn::Max(span.longest, kLacks ? hn::IfThenElseZero(has, length) : length);
    }
    return span;
  }

  GVX_PIECE void see_step(float step, const Places& front, const Places& back, Mask active) {
    const Float centre = all(step), begin = all(step - 0.5f), units = all(batch_.units);
    const Span whole = span_of(front, back, begin, all(step + 0.5f), active);
    const Mask visible = hn::And(active, hn::Gt(whole.extinction, hn::Zero(kFloats)));
    if (none(visible)) return;
    // Where the values change fast they do not change evenly.
    const Float adds = hn::Mul(left(), hn::Min(hn::Mul(whole.extinction, units), all(1)));
    const Pieces cuts = cuts_of(adds, whole.longest);
    const float most = cuts.most(visible);
    if (!(most > 1)) return see(whole, front, back, centre, units, visible);
    Places from = front, to;
    Float at = begin;
    for (float cut = 0; cut < most; cut += 1) {
      const Mask mask = hn::And(hn::And(visible, going()), cuts.has(cut));
      if (none(mask)) return;
      const Float next = hn::Add(begin, cuts.end(cut));
      // A step that is not cut ends where it was sampled already.
      sample(next, hn::And(mask, cuts.has(1)), to);
      const Span span = span_of(from, to, at, next, mask);
      const Mask some = hn::And(mask, hn::Gt(span.extinction, hn::Zero(kFloats)));
      if (!none(some)) see(span, from, to, centre, hn::Mul(units, hn::Sub(next, at)), some);
      from = to;
      at = next;
    }
  }

  /// see_span, and its light: of the lanes of `mask`.
  HWY_NOINLINE void see(const Span& span, const Places& from, const Places& to, Float centre, Float units,
                        Mask mask) {
    const Float zero = hn::Zero(kFloats);
    Slopes slopes;
    Float factor[kMaxChannels], lit_at = centre;
    for (std::uint32_t c = 0; c < channels_; ++c) factor[c] = all(1);
    if (by_gradient_) {
      lit_at = held_in_voxel<kLacks>(rays_.fine, centre, hn::Mul(all(0.5f), hn::Add(span.begin, span.end)));
      find_slopes(lit_at, slopes);
      for (std::uint32_t c = 0; c < channels_; ++c) {
        if (!functions_[c].by_gradient()) continue;
        factor[c] = rays_.factor_of(functions_[c], slopes.gradient[c], slopes.blend);
      }
    }
    SeenOf seen;
    seen.total = seen.moment = zero;
    for (std::uint32_t c = 0; c < channels_; ++c) {
      seen.color[c] = {zero, zero, zero};
      seen.weight[c] = zero;
    }
    const Pieces parts = parts_of(hn::Mul(left(), hn::Mul(span.extinction, units)), span.longest);
    const float most = parts.most(mask);
    Float at = zero;
    for (float part = 0; part < most; part += 1) {
      const Mask here = hn::And(hn::And(mask, going()), parts.has(part));
      const Float next = parts.end(part);
      Matter matter[kMaxChannels];
      for (std::uint32_t c = 0; c < channels_; ++c) {
        const Float a = from.channel[c].entry, b = to.channel[c].entry;
        const Mask has = of_data(from.channel[c], to.channel[c], here);
        matter[c] = most > 1
                        ? Means(functions_[c])
                              .mean(mix(a, b, at), hn::IfThenElse(hn::Lt(next, all(1)), mix(a, b, next), b),
                                    span.variance3[c], has)
                        : span.matter[c];
        for (Float& number : matter[c].part) number = hn::Mul(factor[c], number);
      }
      const Float middle = hn::Mul(all(0.5f), hn::Add(at, next));
      see_part(matter, hn::Mul(units, hn::Sub(next, at)), mix(span.begin, span.end, middle), here, seen);
      at = next;
    }
    if (none(hn::Gt(seen.total, zero))) return;
    if (!rays_.lit()) return add(seen);
    if (!by_gradient_) {
      // Lit where it is seen: a surface may begin near the back end.
      const Mask some = hn::Gt(seen.total, zero);
      const Float place = hn::Div(seen.moment, hn::IfThenElse(some, seen.total, all(1)));
      lit_at = held_in_voxel<kLacks>(rays_.fine, centre, hn::IfThenElse(some, place, centre));
      find_slopes(lit_at, slopes);
    }
    add_lit(lit_at, slopes, seen);
  }

  GVX_PIECE void see_part(const Matter (&matter)[kMaxChannels], Float units, Float i, Mask mask,
                          SeenOf& seen) {
    const Float zero = hn::Zero(kFloats);
    Float extinction = zero;
    for (std::uint32_t c = 0; c < channels_; ++c) extinction = hn::Add(extinction, matter[c].part[3]);
    mask = hn::And(mask, hn::Gt(extinction, zero));
    const Float weight = hn::IfThenElseZero(mask, hn::Mul(left(), opacity_of(hn::Mul(extinction, units))));
    const Float of_color = hn::Div(weight, hn::IfThenElse(mask, extinction, all(1)));
    for (std::uint32_t c = 0; c < channels_; ++c) {
      const auto& part = matter[c].part;
      Vec3v& color = seen.color[c];
      color = {hn::MulAdd(of_color, part[0], color.x), hn::MulAdd(of_color, part[1], color.y),
               hn::MulAdd(of_color, part[2], color.z)};
      seen.weight[c] = hn::MulAdd(of_color, part[3], seen.weight[c]);
    }
    seen.total = hn::Add(seen.total, weight);
    seen.moment = hn::MulAdd(weight, i, seen.moment);
    opacity_ = hn::Add(opacity_, weight);
  }

  GVX_PIECE void find_slopes(Float i, Slopes& slopes) const {
    slopes.blend = blend_at(i);
    const Vec3v p = rays_.fine.at(i), q = rays_.coarse.at(i);
    for (std::uint32_t c = 0; c < channels_; ++c) {
      Vec3v slope = gradient(texels(batch_.fine, c), edge_, p);
      if (batch_.blended) {
        slope = blended<kLacks>(slope, gradient(texels(batch_.coarse, c), edge_, q), slopes.blend);
      }
      slopes.gradient[c] = or_none<kLacks>(slope);
    }
  }

  HWY_INLINE void add(const SeenOf& seen) {
    for (std::uint32_t c = 0; c < channels_; ++c) {
      color_ = {hn::Add(color_.x, seen.color[c].x), hn::Add(color_.y, seen.color[c].y),
                hn::Add(color_.z, seen.color[c].z)};
    }
  }
  GVX_PIECE void add_lit(Float i, const Slopes& slopes, const SeenOf& seen) {
    for (std::uint32_t c = 0; c < channels_; ++c) {
      // Where nothing is seen shades may be anything.
      const Mask some = hn::Gt(seen.weight[c], hn::Zero(kFloats));
      if (none(some)) continue;
      const Shade shade = rays_.shade(i, c, slopes.gradient[c], slopes.blend);
      const auto lit = [&](Float color, Float body, Float glint, Float& sum) HWY_ATTR {
        const Float more = hn::MulAdd(color, body, hn::Mul(seen.weight[c], glint));
        sum = hn::Add(sum, hn::IfThenElseZero(some, more));
      };
      lit(seen.color[c].x, shade.body.x, shade.glint.x, color_.x);
      lit(seen.color[c].y, shade.body.y, shade.glint.y, color_.y);
      lit(seen.color[c].z, shade.body.z, shade.glint.z, color_.z);
    }
  }

  const scene::Visibility& visibility_;
  const std::uint32_t channels_, planes_;
  StretchBatch& batch_;
  const BatchLanes lanes_;
  const StepRays<kWhole> rays_;
  const int edge_;
  const Function functions_[kMaxChannels];
  bool by_gradient_ = false;
  Vec3v color_;
  Float opacity_;
  Int samples_ = hn::Zero(kInts);
};

template <typename Voxel>
void composite_all(const FrameView& frame, StretchBatch& batch) {
  const Shading<std::is_integral_v<Voxel>> lights(frame);
  batch.opaque_count = 0;
  batch.put_in_order();
  for (std::size_t lane = 0; lane < batch.count; lane += hn::MaxLanes(kFloats)) {
    Channels<Voxel>(frame, lights, batch, lane).run();
  }
}

}  // namespace

void channels_u8(const FrameView& frame, StretchBatch& batch) {
  composite_all<std::uint8_t>(frame, batch);
}
void channels_u16(const FrameView& frame, StretchBatch& batch) {
  composite_all<std::uint16_t>(frame, batch);
}
void channels_f32(const FrameView& frame, StretchBatch& batch) {
  composite_all<float>(frame, batch);
}

}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gvx::render {

HWY_EXPORT(channels_u8);
HWY_EXPORT(channels_u16);
HWY_EXPORT(channels_f32);

void composite_channels_batch(const FrameView& frame, StretchBatch& batch) {
  switch (frame.format.type) {
    case VoxelType::u8:
      return HWY_DYNAMIC_DISPATCH(channels_u8)(frame, batch);
    case VoxelType::u16:
      return HWY_DYNAMIC_DISPATCH(channels_u16)(frame, batch);
    case VoxelType::f32:
      return HWY_DYNAMIC_DISPATCH(channels_f32)(frame, batch);
  }
}

}  // namespace gvx::render
#endif
