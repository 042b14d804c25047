/// \file
/// Isosurface: the first place along a ray where the value is the isovalue, found to a small part of a voxel.
/// Where matter ends at what is no data there is no surface.
#pragma once

#include <cmath>

#include "gvx/render/reference/stretch.h"

namespace gvx::render {

/// Where between steps `a` and `b`, whose values are on both sides of the isovalue, the value crosses it:
/// false position that halves the weight of an end which stays (Illinois).
template <typename Voxel, int M>
GVX_HD float crossing(const RayView& ray, const Stretch<Voxel, M>& s, float a, float value_a, float b,
                      float value_b) {
  constexpr int kRounds = 6;
  float i = a;
  int stayed = 0;
  for (int round = 0; round < kRounds; ++round) {
    i = a + (b - a) * value_a / (value_a - value_b);
    const float value = value_at(s, 0, i, s.blend_at(ray.frame, i)) - ray.frame.visibility.isovalue;
    if (value == 0.0f || std::isnan(value)) return i;
    if ((value < 0.0f) == (value_b < 0.0f)) {
      b = i, value_b = value;
      if (stayed == 1) value_a *= 0.5f;
      stayed = 1;
    } else {
      a = i, value_a = value;
      if (stayed == 2) value_b *= 0.5f;
      stayed = 2;
    }
  }
  return i;
}

template <typename Voxel, int M>
GVX_HD void find_surface(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  float front = value_at(s, 0, -0.5f, s.blend_at(frame, -0.5f)) - frame.visibility.isovalue;
  for (std::int64_t step = 0; step < s.steps; ++step) {
    const float i = static_cast<float>(step);
    const float back = value_at(s, 0, i + 0.5f, s.blend_at(frame, i + 0.5f)) - frame.visibility.isovalue;
    ++state.samples;
    const bool no_data = std::isnan(front) || std::isnan(back);
    if (!no_data && (front < 0.0f) != (back < 0.0f)) {
      const float hit = crossing(ray, s, i - 0.5f, front, i + 0.5f, back);
      const float lit = s.held_in_voxel(i, hit);
      const Vec3f gradient = gradient_or_none(s, 0, lit, s.blend_at(frame, lit)) / frame.soft_gradient[0];
      const scene::Shade<float> shade = ray.shade(gradient, 1, s.t_at(hit));
      add(state, frame.iso_color * shade.body + shade.glint, 1);
      return;
    }
    front = back;
  }
}

}  // namespace gvx::render
