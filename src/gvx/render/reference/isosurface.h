/// \file
/// Isosurface: the first place along a ray where the value is the isovalue, found to a small part of a voxel.
/// Where matter ends at what is no data there is no surface.
#pragma once

#include <cmath>

#include "gvx/render/reference/stretch.h"

namespace gvx::render {

/// The value at place i, told above the isovalue.
template <typename Voxel, int M>
GVX_HD float above_isovalue(const RayView& ray, const Stretch<Voxel, M>& s, float i) {
  return value_at(s, 0, i, s.blend_at(ray.frame, i)) - ray.frame.visibility.isovalue;
}

/// Where in the step with this centre, between whose ends there is a surface, it is.
template <typename Voxel, int M>
GVX_HD float surface_in(const RayView& ray, const Stretch<Voxel, M>& s, float centre, float front,
                        float back) {
  return one_lane::crossing<one_lane::kMayLack<Voxel>>(centre, front, back, true,
                                                       [&](float i) { return above_isovalue(ray, s, i); });
}

template <typename Voxel, int M>
GVX_HD void find_surface(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  float front = above_isovalue(ray, s, -0.5f);
  for (std::int64_t step = 0; step < s.steps; ++step) {
    const float i = static_cast<float>(step);
    const float back = above_isovalue(ray, s, i + 0.5f);
    ++state.samples;
    if (one_lane::crosses<one_lane::kMayLack<Voxel>>(front, back)) {
      const float hit = surface_in(ray, s, i, front, back);
      const float lit = s.held_in_voxel(i, hit);
      const Vec3f gradient = gradient_or_none(s, 0, lit, s.blend_at(frame, lit)) / frame.soft_gradient[0];
      const scene::Shade<float> shade = ray.shade(gradient, 1, s.t_at(hit));
      add(state, one_lane::lit_by(shade, frame.iso_color), 1);
      return;
    }
    front = back;
  }
}

}  // namespace gvx::render
