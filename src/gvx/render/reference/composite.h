/// \file
/// Compositing of scalars: emission and absorption, front to back, of one to four channels.
///
/// The values of a step are taken to go evenly from its front end to its back end, and around that by the
/// deviation of what a coarse voxel stands for: an interval of equally likely values, as wide as gives the
/// same variance. Its mean matter comes from the transfer function's integrals (pre-integration; variances as
/// in Younesy, Moeller, Carr, "Improving the quality of multi-resolution volume rendering", 2006). Where
/// values change fast a step is sampled more often, and what lies between two samples is cut in the
/// function's space, so that its front hides its back.
#pragma once

#include "gvx/render/reference/each_step.h"

namespace gvx::render {

/// The channels on a ray's stretch, as Compositing asks for them. kMost is 1, or the most there can be: then
/// the frame says how many there are.
template <std::uint32_t kMost, typename Voxel, int M>
class StretchChannels : public StepRay<Voxel, M> {
 public:
  using Steps = StepRay<Voxel, M>;
  using Steps::kLacks;

  GVX_HD StretchChannels(const RayView& ray, const Stretch<Voxel, M>& s) : Steps(ray, s) {
    for (std::uint32_t c = 0; c < channels(); ++c) by_gradient_ = by_gradient_ || function(c).by_gradient();
  }

  GVX_HD std::uint32_t channels() const { return kMost == 1 ? 1 : this->ray_.frame.visibility.channels; }
  GVX_HD one_lane::Function function(std::uint32_t channel) const {
    return one_lane::Function(this->ray_.frame.visibility.functions[channel]);
  }
  GVX_HD bool by_gradient() const { return by_gradient_; }
  GVX_HD std::int32_t samples() const { return samples_; }

  GVX_HD void sample(float i, bool counted, one_lane::EntrySample (&places)[kMost]) {
    const float blend = this->blend_at(i);
    for (std::uint32_t c = 0; c < channels(); ++c) {
      const ScalarSample sample = sample_at(this->s_, c, i, blend);
      places[c] = {one_lane::entry_or_none<kLacks>(function(c).entry_of(sample.value)),
                   function(c).to_entries(sample.deviation)};
    }
    samples_ += counted ? 1 : 0;
  }
  GVX_HD float held(float centre, float i) const { return this->s_.held_in_voxel(centre, i); }
  GVX_HD Vec3f gradient(std::uint32_t channel, float i, float blend) const {
    return gradient_or_none(this->s_, channel, i, blend);
  }

 private:
  bool by_gradient_ = false;
  std::int32_t samples_ = 0;
};

template <std::uint32_t kMost, typename Voxel, int M>
GVX_HD void composite_scalars(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  using Channels = StretchChannels<kMost, Voxel, M>;
  Channels channels(ray, s);
  const float units = ray.frame.units_per_tick * static_cast<float>(s.stride);
  one_lane::Compositing<Channels, kMost> compositing(channels, units, state.color, state.opacity);
  compositing.run(static_cast<float>(s.steps));
  state.color = compositing.color();
  state.opacity = compositing.opacity();
  state.samples += channels.samples();
  if (state.opacity >= kOpaque) state.phase = RayPhase::finished;
}

/// Steps of this stride through matter of one value a channel.
GVX_HD inline void composite_constant(const RayView& ray, const ChannelRanges& values, double stride,
                                      std::int64_t steps, RayState& state) {
  const FrameView& frame = ray.frame;
  scene::Matter sum;
  const scene::Shade<float> shade = ray.shade({}, 0, 0);
  for (std::uint32_t c = 0; c < frame.visibility.channels; ++c) {
    const scene::TransferView& function = frame.visibility.functions[c];
    const scene::Matter m = function.at(function.entry_of(values.channel[c].minimum));
    const float factor =
        function.gradient_factor != nullptr ? one_lane::Function(function).factor_of_gradient(0) : 1.0f;
    sum.color = sum.color + factor * m.color * shade.body;
    sum.extinction += factor * m.extinction;
  }
  ++state.samples;
  if (!(sum.extinction > 0.0f)) return;
  const float units = frame.units_per_tick * static_cast<float>(stride);
  add(state, sum.color / sum.extinction, opacity_of(sum.extinction * units * static_cast<float>(steps)));
}

}  // namespace gvx::render
