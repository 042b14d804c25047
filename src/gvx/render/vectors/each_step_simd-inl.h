/// \file
/// Vectors of rays that look at each step by itself: what they gather, and the light of it.
/// Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_EACH_STEP_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_EACH_STEP_SIMD_INL_H
#undef GVX_RENDER_EACH_STEP_SIMD_INL_H
#else
#define GVX_RENDER_EACH_STEP_SIMD_INL_H
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "gvx/render/reference/stretch.h"
#include "gvx/render/tile/stretch_batch.h"
#include "gvx/render/vectors/batch_simd-inl.h"
#include "gvx/render/vectors/gradient_simd-inl.h"
#include "gvx/render/vectors/sample_simd-inl.h"
#include "gvx/render/vectors/shade_simd-inl.h"
#include "gvx/render/vectors/simd_targets.h"
#include "gvx/render/vectors/transfer_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

#include "gvx/render/formula/each_step.inc"

/// A vector of rays, and where their steps are. kWhole as of Shading.
template <bool kWhole>
class StepRays {
 public:
  using Lights = Shading<kWhole>;

  HWY_INLINE StepRays(const Lights& lights, const StretchBatch& batch, const BatchLanes& lanes)
      : fine(lanes.fine(batch)),
        coarse(batch.blended ? lanes.coarse(batch) : fine),
        lights_(lights),
        batch_(batch),
        lanes_(lanes),
        to_eye_(lights.lit() ? lanes.to_eye(batch) : fine.first) {
    if (lights.lit()) lights.find_halves(to_eye_, halves_);
  }

  HWY_INLINE bool lit() const { return lights_.lit(); }
  HWY_INLINE Float blend_at(Float i) const {
    return batch_.blended ? share_at(coarse, i) : hn::Zero(kFloats);
  }

  /// RayView::shade at step i.
  HWY_INLINE Shade shade_certain(Float i, const Vec3v& gradient, Float certainty) const {
    return lights_.shade_certain(gradient, certainty, to_eye_, halves_, point_at(i));
  }
  /// The same by the gradient of a channel of scalars in stored values a voxel, levels blended.
  HWY_NOINLINE Shade shade(Float i, std::uint32_t channel, const Vec3v& gradient, Float blend) const {
    Float scale = all(batch_.fine.gradient_scale);
    if (batch_.blended) scale = mix(scale, all(batch_.coarse.gradient_scale), blend);
    return lights_.shade(channel, gradient, scale, to_eye_, halves_, point_at(i));
  }
  /// What a channel's extinction is multiplied by.
  HWY_INLINE Float factor_of(const Function& function, const Vec3v& gradient, Float blend) const {
    Float across = all(batch_.fine.voxels_across);
    if (batch_.blended) across = mix(across, all(batch_.coarse.voxels_across), blend);
    return function.factor_of_gradient(hn::Mul(hn::Sqrt(lights_.world_length2(gradient)), across));
  }

  const PathRows fine, coarse;

 private:
  HWY_INLINE auto point_at(Float i) const {
    return [this, i]() HWY_ATTR { return lanes_.places(batch_).at(i); };
  }

  const Lights& lights_;
  const StretchBatch& batch_;
  const BatchLanes& lanes_;
  const Vec3v to_eye_;
  typename Lights::FarHalves halves_;
};

/// Content::show(i, rays, active, shown) says what step i shows.
template <typename Content>
void composite_each_step(const FrameView& frame, StretchBatch& batch) {
  using Rays = StepRays<Content::kWhole>;
  const typename Rays::Lights lights(frame);
  const Content content(frame, batch);
  batch.opaque_count = 0;
  batch.put_in_order();
  for (std::size_t lane = 0; lane < batch.count; lane += hn::MaxLanes(kFloats)) {
    const BatchLanes lanes(batch, lane);
    const Rays rays(lights, batch, lanes);
    const Float end = lanes.steps(rays.fine);
    Vec3v color;
    Float opacity;
    lanes.load(batch, color, opacity);
    Int samples = hn::Zero(kInts);
    const float last = hn::GetLane(hn::MaxOfLanes(kFloats, end));
    for (float step = 0; step < last; step += 1) {
      const Float i = all(step);
      const Mask active = hn::And(hn::Lt(i, end), hn::Lt(opacity, all(kOpaque)));
      if (none(active)) break;
      samples = hn::Sub(samples, hn::VecFromMask(kInts, hn::RebindMask(kInts, active)));
      Shown shown;
      content.show(i, rays, active, shown);
      if (none(shown.seen)) continue;
      put_behind(shown.seen, shown.color, shown.opacity, color, opacity);
    }
    lanes.store(batch, color, opacity, samples);
  }
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
