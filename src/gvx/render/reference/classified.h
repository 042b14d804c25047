/// \file
/// Compositing of voxels that are classified already: labels, which never blend, and colours, with or without
/// normals.
#pragma once

#include <cmath>

#include "gvx/render/reference/stretch.h"

namespace gvx::render {

/// Where a label's own region changes by less than the inverse of this a voxel, nothing is near that it ends
/// at: what is left of the gradient is rounding, and no normal.
inline constexpr float kRegionSharpness = 64;

/// How much a label's own region changes along each axis around a position: minus the outward normal.
template <int M, typename Voxel>
GVX_HD inline Vec3f region_gradient(const Voxel* labels, Vec3f position, Voxel label) {
  return brick::spline_gradient<M>(position,
                                   [&](int offset) { return labels[offset] == label ? 1.0f : 0.0f; });
}

template <typename Voxel, int M>
GVX_HD void composite_labels(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  const float units = frame.units_per_tick * static_cast<float>(s.stride);
  const Voxel* labels = s.fine.brick.plane(0);
  for (std::int64_t step = 0; step < s.steps; ++step) {
    const float i = static_cast<float>(step);
    const Vec3f position = s.fine.at(i);
    const Voxel label = labels[brick::nearest_offset<M>(position)];
    const scene::Matter m = frame.visibility.functions[0].of_label(static_cast<std::uint32_t>(label));
    ++state.samples;
    if (!(m.extinction > 0.0f)) continue;
    const Vec3f gradient =
        frame.lighting.lighting.enabled ? region_gradient<M>(labels, position, label) : Vec3f{};
    const float certainty = std::fmin(kRegionSharpness * length(gradient), 1.0f);
    const scene::Shade<float> shade = ray.shade(gradient, certainty, s.t_at(i));
    add(state, (1 / m.extinction) * m.color * shade.body + shade.glint, opacity_of(m.extinction * units));
    if (state.phase == RayPhase::finished) return;
  }
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

/// A colour voxel between its neighbours: colour and opacity as stored, 0 to 1, and a normal, if any.
struct ColorSample {
  Vec3f color;
  float opacity = 0;
  Vec3f normal;
};

template <bool kNormals, int M>
GVX_HD inline ColorSample sample_color(const brick::BrickView<std::uint8_t, M>& b, Vec3f position) {
  const brick::TexelAxis<M> x(position.x), y(position.y), z(position.z);
  const auto plane = [&](std::uint32_t index) { return brick::trilinear<M>(b.plane(index), x, y, z); };
  ColorSample sample;
  sample.opacity = plane(3) / 255;
  if (!(sample.opacity > 0.0f)) return sample;
  sample.color = Vec3f(plane(0), plane(1), plane(2)) / 255.0f;
  if (kNormals) sample.normal = Vec3f(plane(4) - 127, plane(5) - 127, plane(6) - 127) / 127.0f;
  return sample;
}

/// More than this counts as this: all but opaque, of an extinction that is a number.
inline constexpr float kMostOpacity = 0.9999f;
/// An opacity, of 255, that changes by this a voxel is a surface.
inline constexpr float kSurfaceSlope = 16;

/// Opacities are of a voxel of their own level; levels are blended as extinctions.
template <bool kNormals, int M>
GVX_HD void composite_colors(const RayView& ray, const Stretch<std::uint8_t, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  const auto extinction_of = [](float opacity) { return -std::log(1 - std::fmin(opacity, kMostOpacity)); };
  for (std::int64_t step = 0; step < s.steps; ++step) {
    const float i = static_cast<float>(step);
    const float blend = s.blend_at(frame, i);
    const ColorSample fine = sample_color<kNormals>(s.fine.brick, s.fine.at(i));
    float extinction = (1 - blend) * extinction_of(fine.opacity);
    ColorSample mixed{(1 - blend) * fine.color, (1 - blend) * fine.opacity, (1 - blend) * fine.normal};
    if (blend > 0.0f) {
      const ColorSample coarse = sample_color<kNormals>(s.coarse.brick, s.coarse.at(i));
      // A coarse voxel is as many fine ones thick.
      const float thickness = s.coarse.voxels_across / s.fine.voxels_across;
      extinction += blend * thickness * extinction_of(coarse.opacity);
      mixed = {mixed.color + blend * coarse.color, mixed.opacity + blend * coarse.opacity,
               mixed.normal + blend * coarse.normal};
    }
    ++state.samples;
    if (!(extinction > 0.0f) || !(mixed.opacity > 0.0f)) continue;
    Vec3f gradient;
    if (frame.lighting.lighting.enabled) {
      gradient = kNormals ? mixed.normal : brick::gradient<M>(s.fine.brick.plane(3), s.fine.at(i));
    }
    const float steep = kNormals ? length(mixed.normal) / mixed.opacity : length(gradient) / kSurfaceSlope;
    const float certainty = steep < 1.0f ? steep : 1.0f;
    const scene::Shade<float> shade = ray.shade(gradient, certainty, s.t_at(i));
    add(state, (1 / mixed.opacity) * mixed.color * shade.body + shade.glint,
        opacity_of(extinction * frame.voxels_per_step));
    if (state.phase == RayPhase::finished) return;
  }
}

}  // namespace gvx::render
