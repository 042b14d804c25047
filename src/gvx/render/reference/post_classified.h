/// \file
/// Post-classification: each sample is classified and lit by itself, at its step's centre. Faster than
/// composite.h, and what most renderers do; but thin layers of a function fall between samples, deviations of
/// coarse voxels are not looked at, and gradients are those of the cell between eight voxels.
#pragma once

#include <cmath>

#include "gvx/render/reference/stretch.h"

namespace gvx::render {

template <typename Voxel, int M>
GVX_HD void composite_post(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  const scene::Visibility& visibility = frame.visibility;
  const float units = frame.units_per_tick * static_cast<float>(s.stride);
  const bool lit = frame.lighting.lighting.enabled;
  for (std::int64_t step = 0; step < s.steps && state.phase == RayPhase::under_way; ++step) {
    const auto i = static_cast<float>(step);
    const float blend = s.blend_at(frame, i);
    scene::Matter sum;
    for (std::uint32_t c = 0; c < visibility.channels; ++c) {
      const scene::TransferView& function = visibility.functions[c];
      brick::CellSample sample = blended(s, blend, [&](const BrickPath<Voxel, M>& path) {
        return brick::cell_sample<M>(path.brick.plane(c), path.at(i));
      });
      if (s.noisy != nullptr) {
        sample.gradient = sample.gradient + s.noise_gradient(sample.value, sample.gradient, i);
        sample.value = s.with_noise(sample.value, i);
      }
      const float entry = function.entry_of(sample.value);
      if (std::isnan(entry) || function.invisible(entry, entry)) continue;
      const scene::Matter m = function.matter[function.nearest(entry)];
      if (!(m.extinction > 0.0f)) continue;
      scene::Shade<float> shade;
      if (lit) {
        const Vec3f relative = sample.gradient / frame.soft_gradient[c];
        const float steep = s.gradient_scale(frame, blend) * length(relative);
        shade = ray.shade(relative, scene::surface_certainty(steep, 1.0f), s.t_at(i));
      }
      float factor = 1;
      if (function.gradient_factor != nullptr) {
        const float voxels = s.fine.voxels_across * (1 - blend) + s.coarse.voxels_across * blend;
        const Vec3f world = Vec3f(frame.world_to_tree.transposed_vector(Vec3d(sample.gradient)));
        factor = function.factor_of_gradient(length(world) * voxels);
      }
      const float weight = factor * m.extinction;
      sum.color = sum.color + factor * m.color * shade.body + weight * shade.glint;
      sum.extinction += weight;
    }
    ++state.samples;
    if (!(sum.extinction > 0.0f)) continue;
    add(state, sum.color / sum.extinction, opacity_of(sum.extinction * units));
  }
}

}  // namespace gvx::render
