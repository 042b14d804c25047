/// \file
/// Post-classification: each sample is classified and lit by itself, at its step's centre. Faster than
/// composite.h, and what most renderers do; but thin layers of a function fall between samples, deviations of
/// coarse voxels are not looked at, and gradients are those of the cell between eight voxels.
#pragma once

#include <cmath>

#include "gvx/render/reference/each_step.h"

namespace gvx::render {

template <typename Voxel, int M>
GVX_HD void composite_post(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const StepRay<Voxel, M> steps(ray, s);
  const float units = ray.frame.units_per_tick * static_cast<float>(s.stride);
  const auto show = [&](float i, one_lane::Shown& shown) {
    const auto sample_of = [&](std::uint32_t c, float blend, bool add_gradient) {
      one_lane::CellSample sample = blended(s, blend, [&](const BrickPath<Voxel, M>& path) {
        return one_lane::cell_sample(path.texels(c), M, path.at(i), add_gradient);
      });
      if (s.noisy != nullptr) {
        sample.gradient = sample.gradient + s.noise_gradient(sample.value, sample.gradient, i);
        sample.value = s.with_noise(sample.value, i);
      }
      return sample;
    };
    one_lane::show_scalars<one_lane::kMayLack<Voxel>>(ray.frame.visibility, units, steps, i, true, sample_of,
                                                      shown);
  };
  composite_each_step(s.steps, show, state);
}

}  // namespace gvx::render
