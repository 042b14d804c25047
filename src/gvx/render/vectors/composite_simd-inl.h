/// \file
/// composite_batch: what composite.h does, with a ray in each lane of a vector. The loop is one of its own,
/// beside that of formula/composite.inc; the formulas are shared. Rays take plain steps side by side; those
/// that come to a step that must be cut wait, are put side by side anew, and go on. Compiled once for each
/// instruction set, a source a voxel type (composite_u8_simd.cpp and its kin).

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_COMPOSITE_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_COMPOSITE_SIMD_INL_H
#undef GVX_RENDER_COMPOSITE_SIMD_INL_H
#else
#define GVX_RENDER_COMPOSITE_SIMD_INL_H
#endif

// Before any of Highway.
// clang-format off
#include "gvx/render/vectors/simd_targets.h"
// clang-format on

#include <type_traits>

#include <hwy/highway.h>

#include "gvx/render/reference/composite.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/composite_rays_simd-inl.h"
#include "gvx/render/vectors/visible_steps_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// Steps of several vectors of rays at once, each to its end or to a step that must be cut: there a ray
/// waits, so that those that are cut fill vectors.
template <typename RaysOf, int kVectors>
class Stepping {
 public:
  using Means = HWY_NAMESPACE::Means<RaysOf::kPlain, RaysOf::kLacks>;

  HWY_INLINE Stepping(StretchBatch& batch, const Function& function, RaysOf (&rays)[kVectors])
      : batch_(batch), function_(function), rays_(rays) {}

  /// `begun`: they go on from where they waited.
  HWY_INLINE void run(bool begun) {
    for (int k = 0; k < kVectors; ++k) waits_[k] = no_lanes();
    if (begun) {
      go_on();
    } else {
      begin();
    }
    Means means[2] = {Means(function_), Means(function_)};
    while (true) {
      for (int k = 0; k < kVectors; ++k) {
        active_[k] = hn::And(hn::And(active_[k], hn::Lt(step_[k], rays_[k].end())), rays_[k].going());
      }
      if (none_of(active_)) break;
      EntrySample back[kVectors];
      Mask visible[kVectors];
      look_ahead(means, back, visible);
      const bool some_visible = !none_of(visible);
      for (int k = 0; k < kVectors; ++k) {
        if (some_visible) see_step(k, means[k], back[k], visible[k]);
        front_[k] = back[k];
        step_[k] = hn::Add(step_[k], all(1));
        if (!some_visible) means[k] = Means(function_);
      }
    }
    for (int k = 0; k < kVectors; ++k) {
      rays_[k].store();
      if (none(waits_[k])) continue;
      rays_[k].lanes().wait(batch_, waits_[k], wait_[k], batch_.waiting_row, batch_.waiting_count);
    }
  }

 private:
  HWY_INLINE void begin() {
    Float front[kVectors];
    for (int k = 0; k < kVectors; ++k) {
      step_[k] = rays_[k].first();
      front[k] = hn::Sub(step_[k], all(0.5f));
      active_[k] = hn::And(hn::Lt(step_[k], rays_[k].end()), rays_[k].going());
      rays_[k].count_samples(active_[k]);
    }
    RaysOf::sample_all(rays_, front, front_);
  }
  HWY_INLINE void go_on() {
    for (int k = 0; k < kVectors; ++k) {
      const PathRows waited = rays_[k].lanes().waiting(batch_);
      step_[k] = waited.first.x;
      front_[k] = {waited.first.y, waited.first.z};
      active_[k] = rays_[k].lanes().valid();
    }
  }

  /// Finds the places where the steps end, and which of them have something to see.
  HWY_INLINE void look_ahead(const Means (&means)[2], EntrySample (&back)[kVectors],
                             Mask (&visible)[kVectors]) {
    Float end[kVectors];
    for (int k = 0; k < kVectors; ++k) end[k] = hn::Add(step_[k], all(0.5f));
    RaysOf::sample_all(rays_, end, back);
    for (int k = 0; k < kVectors; ++k) {
      rays_[k].count_samples(active_[k]);
      visible[k] = hn::AndNot(means[k].unseen(front_[k], back[k]), active_[k]);
    }
  }

  HWY_INLINE void see_step(int k, Means& means, const EntrySample& back, Mask visible) {
    RaysOf& rays = rays_[k];
    const EntrySample& front = front_[k];
    const Float variance3 = Means::variance3(front, back);
    const Matter matter = means.mean(front.entry, back.entry, variance3, visible);
    const Float extinction = matter.part[3], units = all(batch_.units);
    visible = hn::And(visible, hn::Gt(extinction, hn::Zero(kFloats)));
    if (none(visible)) return;
    const Float longest = rays.length(front, back);
    const Mask waiting = hn::And(visible, rays.is_cut(extinction, units, longest));
    if (!none(waiting)) {
      const Float numbers[5] = {step_[k], front.entry, front.deviation, back.entry, back.deviation};
      for (int n = 0; n < 5; ++n) wait_[k][n] = hn::IfThenElse(waiting, numbers[n], wait_[k][n]);
      waits_[k] = hn::Or(waits_[k], waiting);
      active_[k] = hn::AndNot(waiting, active_[k]);
      visible = hn::AndNot(waiting, visible);
      if (none(visible)) return;
    }
    const Float centre = step_[k];
    Seen seen = Seen::nothing();
    if (rays.by_gradient()) {
      const Slope slope = rays.slope_at(centre);
      rays.see(matter, hn::Mul(units, rays.factor_of(slope)), centre, visible, seen);
      return rays.add_lit(centre, slope, seen);
    }
    rays.see(matter, units, centre, visible, seen);
    if (!rays.is_lit()) return rays.add(seen);
    rays.add_lit(centre, rays.slope_at(centre), seen);
  }

  StretchBatch& batch_;
  const Function& function_;
  RaysOf (&rays_)[kVectors];
  Float step_[kVectors];
  EntrySample front_[kVectors];
  Mask active_[kVectors];
  Mask waits_[kVectors];
  Float wait_[kVectors][5];  // StretchBatch::waiting
};

/// The steps that a vector of rays waits for: each is cut.
template <typename RaysOf>
class Cutting {
 public:
  using Means = HWY_NAMESPACE::Means<RaysOf::kPlain, RaysOf::kLacks>;

  HWY_INLINE Cutting(StretchBatch& batch, const Function& function, RaysOf& rays)
      : batch_(batch), rays_(rays), means_(function) {}

  /// Rays that have a next step are appended to the batch's order.
  HWY_NOINLINE void run(std::uint32_t& going_on) {
    const PathRows waited = rays_.lanes().waiting(batch_);
    const Mask valid = rays_.lanes().valid();
    centre_ = waited.first.x;
    EntrySample from{waited.first.y, waited.first.z};
    const EntrySample back{waited.fourth, waited.per_step.x};
    Means ahead = means_;
    const Matter whole = ahead.mean(from.entry, back.entry, Means::variance3(from, back), valid);
    const Pieces cuts = rays_.cuts(whole.part[3], rays_.length(from, back));
    const Float front = hn::Sub(centre_, all(0.5f));
    const float most = cuts.most(valid);
    Float begin = front;
    for (float cut = 0; cut < most; cut += 1) {
      const Mask mask = hn::And(hn::And(valid, rays_.going()), cuts.has(cut));
      if (none(mask)) break;
      const Float end = hn::Add(front, cuts.end(cut));
      const EntrySample to = rays_.at(end);
      // A step that is not cut ends where it was sampled already.
      rays_.count_samples(hn::And(mask, cuts.has(1)));
      see_span(from, to, begin, end, mask);
      from = to;
      begin = end;
    }
    rays_.store();
    const Float next = hn::Add(centre_, all(1));
    const Float numbers[5] = {next, back.entry, back.deviation, back.entry, back.deviation};
    const Mask on = hn::And(hn::And(valid, rays_.going()), hn::Lt(next, rays_.end()));
    rays_.lanes().wait(batch_, on, numbers, batch_.order, going_on);
  }

 private:
  HWY_NOINLINE void see_span(const EntrySample& from, const EntrySample& to, Float begin, Float end,
                             Mask mask) {
    const Float length = hn::Sub(end, begin);
    Float units = hn::Mul(all(batch_.units), length);
    const Float variance3 = Means::variance3(from, to);
    Means ahead = means_;
    if constexpr (RaysOf::kLacks) mask = hn::AndNot(lack(from, to), mask);
    const Matter whole = ahead.mean(from.entry, to.entry, variance3, mask);
    mask = hn::And(mask, hn::Gt(whole.part[3], hn::Zero(kFloats)));
    if (none(mask)) {
      means_ = ahead;
      return;
    }
    const Float way = hn::Sub(to.entry, from.entry);
    const Pieces parts = rays_.parts(whole.part[3], units, rays_.length(from, to));
    Seen seen = Seen::nothing();
    Float lit_at = centre_;
    Slope slope;
    if (rays_.by_gradient()) {
      lit_at = rays_.held(centre_, hn::MulAdd(all(0.5f), length, begin));
      slope = rays_.slope_at(lit_at);
      units = hn::Mul(units, rays_.factor_of(slope));
    }
    if (none(hn::And(mask, parts.has(1)))) {
      rays_.see(whole, units, hn::MulAdd(all(0.5f), length, begin), mask, seen);
      means_ = ahead;
    } else {
      const float most = parts.most(mask);
      Float at = hn::Zero(kFloats), entry = from.entry;
      for (float part = 0; part < most; part += 1) {
        const Float next = parts.end(part);
        const Float next_entry =
            hn::IfThenElse(hn::Lt(next, all(1)), hn::MulAdd(next, way, from.entry), to.entry);
        const Mask here = hn::And(mask, parts.has(part));
        const Matter matter = means_.mean(entry, next_entry, variance3, here);
        const Float middle = hn::Mul(all(0.5f), hn::Add(at, next));
        rays_.see(matter, hn::Mul(units, hn::Sub(next, at)), hn::MulAdd(middle, length, begin), here, seen);
        at = next;
        entry = next_entry;
      }
    }
    if (!rays_.is_lit()) return rays_.add(seen);
    if (!rays_.by_gradient()) {
      const Mask some = hn::Gt(seen.weight, hn::Zero(kFloats));
      if (none(some)) return;
      // Lit where it is seen: a surface may begin near the back end.
      const Float middle = hn::Div(seen.moment, hn::IfThenElse(some, seen.weight, all(1)));
      lit_at = rays_.held(centre_, hn::IfThenElse(some, middle, centre_));
      slope = rays_.slope_at(lit_at);
    }
    rays_.add_lit(lit_at, slope, seen);
  }

  StretchBatch& batch_;
  RaysOf& rays_;
  Means means_;
  Float centre_;
};

template <typename Layout, bool kPlain>
void composite_with(const FrameView& frame, StretchBatch& batch, const StepRuns& runs) {
  using RaysOf = Rays<Layout, kPlain>;
  constexpr std::size_t kLanes = hn::MaxLanes(kFloats);
  const Bricks<Layout> bricks(frame, batch);
  const Function& function = bricks.function;
  const typename RaysOf::Lights lights(frame);
  const auto rays_at = [&](const std::int32_t* rows, std::size_t count)
                           HWY_ATTR { return RaysOf(frame, lights, batch, runs, bricks, rows, count); };
  std::uint32_t stepping = batch.count;
  for (bool begun = false; stepping > 0; begun = true) {
    batch.waiting_count = 0;
    std::size_t lane = begun ? 0 : runs.hidden;
    if constexpr (kPlain && GVX_VECTORS_SIDE_BY_SIDE >= 2) {
      for (; lane + kLanes < stepping; lane += 2 * kLanes) {
        RaysOf rays[2] = {rays_at(batch.order + lane, kLanes),
                          rays_at(batch.order + lane + kLanes, stepping - lane - kLanes)};
        Stepping<RaysOf, 2>(batch, function, rays).run(begun);
      }
    }
    for (; lane < stepping; lane += kLanes) {
      RaysOf rays[1] = {rays_at(batch.order + lane, stepping - lane)};
      Stepping<RaysOf, 1>(batch, function, rays).run(begun);
    }
    stepping = 0;
    for (lane = 0; lane < batch.waiting_count; lane += kLanes) {
      RaysOf rays = rays_at(batch.waiting_row + lane, batch.waiting_count - lane);
      Cutting<RaysOf>(batch, function, rays).run(stepping);
    }
  }
}

template <typename Layout>
void composite_in(const FrameView& frame, StretchBatch& batch, const StepRuns& runs) {
  if (batch.blended || batch.fine.deviates) return composite_with<Layout, false>(frame, batch, runs);
  composite_with<Layout, true>(frame, batch, runs);
}

template <typename Voxel>
void composite_all(const FrameView& frame, StretchBatch& batch) {
  batch.opaque_count = 0;
  const bool has_other_layout = LaidOut<Voxel>::kQuads || batch.blended || batch.fine.deviates;
  const bool gradients =
      frame.lighting.lighting.enabled || frame.visibility.functions[0].gradient_factor != nullptr;
  bool laid_out = false;
  in_runs<LooksAt::ends>(batch, [&](const StepRuns& runs) HWY_ATTR {
    if (!laid_out && has_other_layout && pays_to_lay_out(batch)) {
      LaidOut<Voxel>::make(batch, gradients, batch.fine);
      if (batch.blended) LaidOut<Voxel>::make(batch, gradients, batch.coarse);
      laid_out = true;
    }
    if (laid_out) return composite_in<LaidOut<Voxel>>(frame, batch, runs);
    composite_in<AsStored<Voxel>>(frame, batch, runs);
  });
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
