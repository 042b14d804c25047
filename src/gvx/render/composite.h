/// \file
/// Compositing of scalars: emission and absorption, front to back, of one to four channels.
///
/// The values of a step are taken to go evenly from its front end to its back end, and around that by the
/// deviation of what a coarse voxel stands for: an interval of equally likely values, as wide as gives the
/// same variance. Its mean matter comes from the transfer function's integrals (pre-integration; variances as
/// in Younesy, Moeller, Carr, "Improving the quality of multi-resolution volume rendering", 2006). A step
/// that is both thick and goes far through the function is cut, so that its front hides its back.
#pragma once

#include <cmath>

#include "gvx/render/stretch.h"

namespace gvx::render {

/// An interval of a transfer function's entries along a step.
struct EntryPath {
  float front = 0, back = 0;
  float variance3 = 0;  ///< three times the variance around it

  /// The mean matter of part `part` of `parts`.
  GVX_HD scene::Matter mean(const scene::TransferView& function, int part, int parts) const {
    const float length = (back - front) / static_cast<float>(parts);
    const float centre = front + (static_cast<float>(part) + 0.5f) * length;
    const float half =
        variance3 > 0.0f ? std::sqrt(variance3 + 0.25f * length * length) : 0.5f * std::fabs(length);
    return function.mean(centre - half, centre + half);
  }
};

// A step of more optical depth than this is cut, if it goes through more than this many entries of the
// function.
inline constexpr float kThinDepth = 0.25f;
inline constexpr float kNarrowPath = 8.0f;
inline constexpr int kMostParts = 8;

/// kChannels is 1, or the most there can be: then the frame says how many.
template <std::uint32_t kChannels, typename Voxel, int M>
GVX_HD void composite_scalars(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  const scene::Visibility& visibility = frame.visibility;
  const std::uint32_t channels = kChannels == 1 ? 1 : visibility.channels;
  const float units = frame.units_per_tick * static_cast<float>(frame.stride[s.level]);
  ScalarSample front[kChannels];
  const float first_blend = s.blend_at(frame, -0.5f);
  for (std::uint32_t c = 0; c < channels; ++c) front[c] = sample_at(s, c, -0.5f, first_blend);

  for (std::int64_t step = 0; step < s.steps; ++step) {
    const float i = static_cast<float>(step);
    const float blend = s.blend_at(frame, i + 0.5f);
    EntryPath path[kChannels];
    scene::Matter matter[kChannels];
    float extinction = 0, longest = 0;
    for (std::uint32_t c = 0; c < channels; ++c) {
      const scene::TransferView& function = visibility.functions[c];
      const ScalarSample back = sample_at(s, c, i + 0.5f, blend);
      const float deviation = 0.5f * (front[c].deviation + back.deviation) * function.to_entry_scale;
      path[c] = {function.entry_of(front[c].value), function.entry_of(back.value), 3 * deviation * deviation};
      front[c] = back;
      matter[c] = path[c].mean(function, 0, 1);
      extinction += matter[c].extinction;
      longest = std::fmax(longest, std::fabs(path[c].back - path[c].front));
    }
    ++state.samples;
    if (!(extinction > 0.0f)) continue;

    scene::Shade<float> shade[kChannels];
    float factor[kChannels];
    const float centre_blend = s.blend_at(frame, i);
    for (std::uint32_t c = 0; c < channels; ++c) {
      factor[c] = 1;
      const bool by_gradient = visibility.functions[c].gradient_factor != nullptr;
      if (!(matter[c].extinction > 0.0f) || !(by_gradient || frame.lighting.lighting.enabled)) continue;
      const Vec3f gradient = gradient_at(s, c, i, centre_blend);
      const float steep = length(gradient);
      shade[c] = ray.shade(gradient, steep / (steep + frame.soft_gradient[c]), s.t_at(i));
      if (by_gradient) {
        const float voxels =
            s.fine.voxels_across * (1 - centre_blend) + s.coarse.voxels_across * centre_blend;
        const Vec3f world = Vec3f(frame.world_to_tree.transposed_vector(Vec3d(gradient)));
        factor[c] = visibility.functions[c].factor_of_gradient(length(world) * voxels);
      }
    }
    const float depth = extinction * units;
    const int parts = depth > kThinDepth && longest > kNarrowPath
                          ? static_cast<int>(std::fmin(1 + depth / kThinDepth, float(kMostParts)))
                          : 1;
    for (int part = 0; part < parts; ++part) {
      scene::Matter sum;
      for (std::uint32_t c = 0; c < channels; ++c) {
        if (!(matter[c].extinction > 0.0f)) continue;
        const scene::Matter here =
            parts == 1 ? matter[c] : path[c].mean(visibility.functions[c], part, parts);
        const float weight = factor[c] * here.extinction;
        sum.color = sum.color + factor[c] * here.color * shade[c].body + weight * shade[c].glint;
        sum.extinction += weight;
      }
      if (!(sum.extinction > 0.0f)) continue;
      add(state, sum.color / sum.extinction, opacity_of(sum.extinction * units / static_cast<float>(parts)));
      if (state.phase == RayPhase::finished) return;
    }
  }
}

/// Steps through matter of one value a channel.
GVX_HD inline void composite_constant(const RayView& ray, const ChannelRanges& values, int level,
                                      std::int64_t steps, RayState& state) {
  const FrameView& frame = ray.frame;
  scene::Matter sum;
  const scene::Shade<float> shade = ray.shade({}, 0, 0);
  for (std::uint32_t c = 0; c < frame.visibility.channels; ++c) {
    const scene::TransferView& function = frame.visibility.functions[c];
    const scene::Matter m = function.at(function.entry_of(values.channel[c].minimum));
    const float factor = function.gradient_factor != nullptr ? function.factor_of_gradient(0) : 1.0f;
    sum.color = sum.color + factor * m.color * shade.body;
    sum.extinction += factor * m.extinction;
  }
  ++state.samples;
  if (!(sum.extinction > 0.0f)) return;
  const float units = frame.units_per_tick * static_cast<float>(frame.stride[level]);
  add(state, sum.color / sum.extinction, opacity_of(sum.extinction * units * static_cast<float>(steps)));
}

}  // namespace gvx::render
