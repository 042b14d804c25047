/// \file
/// Where along a ray its opacity comes to a given value: how deep a pixel is. Apart from what gathers
/// colours, so that a picture without depth costs what it did.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/render/reference/gather.h"
#include "gvx/render/reference/isosurface.h"
#include "gvx/render/reference/stretch.h"

namespace gvx::render {

/// The share of a way through one matter, along which the opacity grows from `before` to `after`, at which it
/// is `opacity`, which lies between them.
GVX_HD inline double share_to(float before, float after, float opacity) {
  const double all = std::log((1 - double(before)) / (1 - double(after)));
  return all < INFINITY ? std::log((1 - double(before)) / (1 - double(opacity))) / all : 0;
}

/// Does a ray end at the first place where the value is the isovalue?
GVX_HD inline bool finds_surfaces(const FrameView& frame) {
  return frame.visibility.mode == scene::Mode::isosurface && frame.format.content == VoxelContent::scalar;
}

/// Where within one step that holds a surface it is, in steps from the centre.
template <typename Voxel, int M>
GVX_HD float surface_in(const RayView& ray, const Stretch<Voxel, M>& one) {
  return surface_in(ray, one, 0, above_isovalue(ray, one, -0.5f), above_isovalue(ray, one, 0.5f));
}

/// Gathers from a stretch, step by step, until the ray has this opacity; returns at what distance from the
/// eye that is, or infinity behind all steps.
template <typename Voxel, int M>
GVX_HD double distance_in(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state, float opacity) {
  for (std::int64_t step = 0; step < s.steps; ++step) {
    const Stretch<Voxel, M> one = one_step(s, static_cast<float>(step));
    const float before = state.opacity;
    gather_stretch(ray, one, state);
    if (state.opacity < opacity) continue;
    const double i = finds_surfaces(ray.frame) ? double(surface_in(ray, one))
                                               : share_to(before, state.opacity, opacity) - 0.5;
    return one.t_centre + i * one.t_step;
  }
  return INFINITY;
}

}  // namespace gvx::render
