/// \file
/// Compositing of voxels that are classified already: labels, which never blend, and colours, with or without
/// normals.
#pragma once

#include <cstdint>

#include "gvx/render/reference/each_step.h"

namespace gvx::render {

template <typename Voxel, int M>
GVX_HD void composite_labels(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  const StepRay<Voxel, M> steps(ray, s);
  const one_lane::Labels<one_lane::PlainTexels<Voxel>> labels{
      s.fine.texels(0), M, one_lane::Function(frame.visibility.functions[0]),
      frame.units_per_tick * static_cast<float>(s.stride)};
  composite_each_step(
      s.steps, [&](float i, one_lane::Shown& shown) { labels.show(steps, i, true, shown); }, state);
}

/// Steps of this stride through matter of one label.
GVX_HD inline void composite_label(const RayView& ray, float label, double stride, std::int64_t steps,
                                   RayState& state) {
  const FrameView& frame = ray.frame;
  const scene::Matter m = frame.visibility.functions[0].of_label(static_cast<std::uint32_t>(label));
  ++state.samples;
  if (!(m.extinction > 0.0f)) return;
  const float units = frame.units_per_tick * static_cast<float>(stride);
  add(state, (1 / m.extinction) * m.color * ray.shade({}, 0, 0).body,
      opacity_of(m.extinction * units * static_cast<float>(steps)));
}

template <bool kNormals, int M>
GVX_HD void composite_colors(const RayView& ray, const Stretch<std::uint8_t, M>& s, RayState& state) {
  const StepRay<std::uint8_t, M> steps(ray, s);
  const auto planes = [](const BrickPath<std::uint8_t, M>& path) {
    return [&path](std::uint32_t index) { return path.texels(index); };
  };
  const one_lane::Colors<kNormals, decltype(planes(s.fine))> colors{
      planes(s.fine),           planes(s.coarse), M, s.blended, s.coarse.voxels_across / s.fine.voxels_across,
      ray.frame.voxels_per_step};
  composite_each_step(
      s.steps, [&](float i, one_lane::Shown& shown) { colors.show(steps, i, true, shown); }, state);
}

}  // namespace gvx::render
