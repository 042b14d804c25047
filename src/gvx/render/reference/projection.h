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

/// Of means, how many ticks of the ray were no data; where there is no room for it, of three and four
/// channels, that counts as 0.
GVX_HD inline float* ticks_without_data(RayState& state, std::uint32_t channel, std::uint32_t channels) {
  return channels <= 2 ? &gathered(state, channels + channel) : nullptr;
}

/// Can nothing within these ranges change what was gathered?
GVX_HD inline bool outdone(scene::Mode mode, RayState& state, std::uint32_t channel, ValueRange range) {
  if (state.samples == 0) return false;
  return mode == scene::Mode::maximum   ? range.maximum <= gathered(state, channel)
         : mode == scene::Mode::minimum ? range.minimum >= gathered(state, channel)
                                        : false;
}

/// Takes steps into what a ray has gathered, each `ticks` long. value_of(channel, step) is what they have.
template <bool kLacks, typename ValueOf>
GVX_HD void project_steps(const scene::Visibility& visibility, std::int64_t steps, float ticks,
                          const ValueOf& value_of, RayState& state) {
  const bool first = state.samples == 0;
  for (std::uint32_t c = 0; c < visibility.channels; ++c) {
    float all = one_lane::begun<kLacks>(visibility.mode, gathered(state, c), first);
    float* const without =
        visibility.mode == scene::Mode::mean ? ticks_without_data(state, c, visibility.channels) : nullptr;
    for (std::int64_t step = 0; step < steps; ++step) {
      const float value = value_of(c, static_cast<float>(step));
      all = one_lane::taken_in<kLacks>(visibility.mode, all, value, ticks);
      if (kLacks && without != nullptr && one_lane::is_no_data(value)) *without += ticks;
    }
    gathered(state, c) = one_lane::ended<kLacks>(visibility.mode, all);
  }
  state.samples += static_cast<std::uint32_t>(steps);
}

template <typename Voxel, int M>
GVX_HD void project_stretch(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  constexpr bool kLacks = one_lane::kMayLack<Voxel>;
  const FrameView& frame = ray.frame;
  const bool by_deviation = scene::seeks_extreme(frame.visibility.mode) && (s.fine_deviates || s.blended);
  const auto value_of = [&](std::uint32_t c, float i) {
    const float blend = s.blend_at(frame, i);
    if (!by_deviation) return value_at(s, c, i, blend);
    const ScalarSample sample = sample_at(s, c, i, blend);
    const ValueRange range = frame.visibility.widened(s.ranges.channel[c]);
    return one_lane::extreme_of<kLacks>(frame.extreme[c], range, sample.value, sample.deviation);
  };
  project_steps<kLacks>(frame.visibility, s.steps, static_cast<float>(s.stride), value_of, state);
}

GVX_HD inline void project_constant(const RayView& ray, const ChannelRanges& values, double stride,
                                    std::int64_t steps, RayState& state) {
  const float ticks = static_cast<float>(stride * static_cast<double>(steps));
  const auto value_of = [&](std::uint32_t c, float) { return values.channel[c].minimum; };
  project_steps<true>(ray.frame.visibility, 1, ticks, value_of, state);
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
