/// \file
/// Projections: the greatest, least or mean value along a ray, of one to four channels, through the transfer
/// functions. Values gather in the ray's colour and opacity, channel by channel, until it ends.
///
/// From afar the greatest value of a coarse voxel is the mean, over the area that it covers, of the greatest
/// values behind each place of it. Let two values be there, the least of all and one that lies `span` above
/// it, and the latter fill a share f of the volume: its share of the area is f to the power of 2/3 where it
/// is a point, f^(1/2) where it is a line seen across, and more where it is a sheet. The line's is taken: it
/// is the quadratic mean, which mean and deviation give. Least values are the same upside down.
#pragma once

#include <cmath>

#include "gvx/render/reference/stretch.h"

namespace gvx::render {

GVX_HD inline float& gathered(RayState& state, std::uint32_t channel) {
  return channel == 0   ? state.color.x
         : channel == 1 ? state.color.y
         : channel == 2 ? state.color.z
                        : state.opacity;
}

// So much more of the variance counts: of two voxels that share a line a ray meets only one. Measured on
// lines of one to three voxels, from pixels of two voxels to pixels of ten.
inline constexpr float kCoveredShare = 1.25f;

/// The greatest or least value of what a sample stands for: no more than its node holds.
GVX_HD inline float extreme_of(const FrameView& frame, std::uint32_t channel, ScalarSample sample,
                               ValueRange range) {
  if (!(sample.deviation > 0.0f) || std::isnan(sample.value)) return sample.value;
  const FrameView::Extreme& extreme = frame.extreme[channel];
  const float away = (sample.value - extreme.from) * extreme.per_span;
  const float deviation = sample.deviation * extreme.per_span;
  const float value =
      extreme.from + extreme.span * std::sqrt(away * away + kCoveredShare * (deviation * deviation));
  return std::fmax(std::fmin(value, range.maximum), range.minimum);
}

/// Of means, how many ticks of the ray were no data; where there is no room for it, of three and four
/// channels, that counts as 0.
GVX_HD inline float* ticks_without_data(RayState& state, std::uint32_t channel, std::uint32_t channels) {
  return channels <= 2 ? &gathered(state, channels + channel) : nullptr;
}

/// Takes in the same values `weight` times. What is no data is passed over.
GVX_HD inline void project(const scene::Visibility& visibility, RayState& state, std::uint32_t channel,
                           float value, float weight) {
  const scene::Mode mode = visibility.mode;
  float& all = gathered(state, channel);
  if (mode == scene::Mode::mean) {
    float* const without = ticks_without_data(state, channel, visibility.channels);
    if (!std::isnan(value)) {
      all += weight * value;
    } else if (without != nullptr) {
      *without += weight;
    }
  } else if (state.samples == 0) {
    all = value;
  } else {
    all = mode == scene::Mode::maximum ? std::fmax(all, value) : std::fmin(all, value);
  }
}

/// Can nothing within these ranges change what was gathered?
GVX_HD inline bool outdone(scene::Mode mode, RayState& state, std::uint32_t channel, ValueRange range) {
  if (state.samples == 0) return false;
  return mode == scene::Mode::maximum   ? range.maximum <= gathered(state, channel)
         : mode == scene::Mode::minimum ? range.minimum >= gathered(state, channel)
                                        : false;
}

template <typename Voxel, int M>
GVX_HD void project_stretch(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  const float ticks = static_cast<float>(s.stride);
  const bool by_deviation = scene::seeks_extreme(frame.visibility.mode) && (s.fine_deviates || s.blended);
  const auto value_of = [&](std::uint32_t c, float i, float blend) {
    if (!by_deviation) return value_at(s, c, i, blend);
    return extreme_of(frame, c, sample_at(s, c, i, blend), frame.visibility.widened(s.ranges.channel[c]));
  };
  for (std::int64_t step = 0; step < s.steps; ++step) {
    const float i = static_cast<float>(step);
    const float blend = s.blend_at(frame, i);
    for (std::uint32_t c = 0; c < frame.visibility.channels; ++c) {
      project(frame.visibility, state, c, value_of(c, i, blend), ticks);
    }
    ++state.samples;
  }
}

GVX_HD inline void project_constant(const RayView& ray, const ChannelRanges& values, double stride,
                                    std::int64_t steps, RayState& state) {
  const float ticks = static_cast<float>(stride * static_cast<double>(steps));
  for (std::uint32_t c = 0; c < ray.frame.visibility.channels; ++c) {
    project(ray.frame.visibility, state, c, values.channel[c].minimum, ticks);
  }
  ++state.samples;
}

/// Did values change what a ray has gathered?
GVX_HD inline bool is_other_projection(const FrameView& frame, const RayState& before, RayState after) {
  RayState old = before;
  bool other = before.samples == 0 && after.samples > 0;
  for (std::uint32_t c = 0; c < frame.visibility.channels; ++c) {
    other = other || gathered(old, c) != gathered(after, c);
  }
  return other;
}

/// At what distance from the eye a stretch last changed what a ray had gathered `before` it; `otherwise`
/// where it did not.
template <typename Voxel, int M>
GVX_HD double changed_in(const RayView& ray, const Stretch<Voxel, M>& s, const RayState& before,
                         const RayState& after, double otherwise) {
  if (!scene::seeks_extreme(ray.frame.visibility.mode) || !is_other_projection(ray.frame, before, after)) {
    return otherwise;
  }
  RayState at = before;
  for (std::int64_t step = 0; step < s.steps; ++step) {
    const RayState last = at;
    const Stretch<Voxel, M> one = one_step(s, static_cast<float>(step));
    project_stretch(ray, one, at);
    if (is_other_projection(ray.frame, last, at)) otherwise = one.t_centre;
  }
  return otherwise;
}

/// At the end of a ray: the values become colours, which add up, and opacities. `ticks` is the ray's length.
GVX_HD inline void finish_projection(const RayView& ray, float ticks, RayState& state) {
  const scene::Visibility& visibility = ray.frame.visibility;
  Vec3f color;
  float left = 1;
  for (std::uint32_t c = 0; state.samples > 0 && c < visibility.channels; ++c) {
    float value = gathered(state, c);
    if (visibility.mode == scene::Mode::mean) {
      const float* const without = ticks_without_data(state, c, visibility.channels);
      const float with_data = without != nullptr ? ticks - *without : ticks;
      // No step is shorter than a tick.
      value = with_data > 0.5f || with_data == ticks ? value / with_data : NAN;
    }
    if (std::isnan(value)) continue;
    const scene::TransferView& function = visibility.functions[c];
    const scene::Matter m = function.at(function.entry_of(value));
    if (!(m.extinction > 0.0f)) continue;
    const float opacity = opacity_of(m.extinction);
    color = color + (opacity / m.extinction) * m.color;
    left *= 1 - opacity;
  }
  const auto held = [](float v) { return v < 1.0f ? v : 1.0f; };
  state.color = {held(color.x), held(color.y), held(color.z)};
  state.opacity = 1 - left;
}

}  // namespace gvx::render
