/// \file
/// StepRay: what the formulas ask of a ray on a stretch; and compositing of steps that are looked at one by
/// one.
#pragma once

#include <cstdint>

#include "gvx/render/reference/stretch.h"

namespace gvx::render {

template <typename Voxel, int M>
class StepRay {
 public:
  static constexpr bool kLacks = one_lane::kMayLack<Voxel>;

  GVX_HD StepRay(const RayView& ray, const Stretch<Voxel, M>& s)
      : fine(s.fine), coarse(s.coarse), ray_(ray), s_(s) {}

  GVX_HD bool lit() const { return ray_.frame.lighting.lighting.enabled; }
  GVX_HD float blend_at(float i) const { return s_.blend_at(ray_.frame, i); }

  GVX_HD float factor_of(const one_lane::Function& function, Vec3f gradient, float blend) const {
    const float voxels = fine.voxels_across * (1 - blend) + coarse.voxels_across * blend;
    const Vec3f world = Vec3f(ray_.frame.world_to_tree.transposed_vector(Vec3d(gradient)));
    return function.factor_of_gradient(length(world) * voxels);
  }
  GVX_HD scene::Shade<float> shade(float i, std::uint32_t channel, Vec3f gradient, float blend) const {
    // Squares of very large or small values would be no numbers.
    const Vec3f relative = gradient / ray_.frame.soft_gradient[channel];
    const float steep = s_.gradient_scale(ray_.frame, blend) * length(relative);
    return shade_certain(i, relative, scene::surface_certainty(steep, 1.0f));
  }
  GVX_HD scene::Shade<float> shade_certain(float i, Vec3f gradient, float certainty) const {
    return ray_.shade(gradient, certainty, s_.t_at(i));
  }

  const BrickPath<Voxel, M>&fine, &coarse;

 protected:
  const RayView& ray_;
  const Stretch<Voxel, M>& s_;
};

/// show(i, shown) says what step i shows.
template <typename Show>
GVX_HD void composite_each_step(std::int64_t steps, const Show& show, RayState& state) {
  for (std::int64_t step = 0; step < steps && state.phase == RayPhase::under_way; ++step) {
    one_lane::Shown shown{};
    show(static_cast<float>(step), shown);
    ++state.samples;
    if (shown.seen) add(state, shown.color, shown.opacity);
  }
}

}  // namespace gvx::render
