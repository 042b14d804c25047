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

#include <cmath>

#include "gvx/render/stretch.h"

namespace gvx::render {

/// The entries of a transfer function that a channel goes through between two places.
struct EntryPath {
  float from = 0, to = 0;
  float variance3 = 0;  ///< three times the variance around it

  GVX_HD float length() const { return std::fabs(to - from); }

  /// The mean matter of part `part` of `parts`.
  GVX_HD scene::Matter mean(const scene::TransferView& function, int part, int parts) const {
    const float length = (to - from) / static_cast<float>(parts);
    const float begin = from + static_cast<float>(part) * length;
    if (!(variance3 > 0.0f)) return function.mean(begin, part + 1 < parts ? begin + length : to);
    const float centre = begin + 0.5f * length;
    const float half = std::sqrt(variance3 + 0.25f * length * length);
    return function.mean(centre - half, centre + half);
  }
};

// A step is sampled at more places the more opaque it is and the more entries of the function it goes
// through: one more for an opaque step through this many.
inline constexpr float kWidePath = 32.0f;
inline constexpr int kMostCuts = 8;
// Between two samples, a span that goes through more entries than this is cut into parts of about this
// optical depth.
inline constexpr float kNarrowPath = 8.0f;
inline constexpr float kThinDepth = 0.25f;
inline constexpr int kMostParts = 8;

/// A part of a step, or all of it, between two samples of each channel. kChannels is 1, or the most there can
/// be: then the frame says how many there are.
template <std::uint32_t kChannels>
struct Span {
  float centre;      ///< of its step
  float begin, end;  ///< in steps
  EntryPath path[kChannels];
  scene::Matter matter[kChannels];
  float extinction = 0;
  float longest = 0;  ///< entries of a function that a channel goes through

  GVX_HD Span(const scene::Visibility& visibility, std::uint32_t channels, float centre_, float begin_,
              float end_, const ScalarSample* front, const ScalarSample* back)
      : centre(centre_), begin(begin_), end(end_) {
    for (std::uint32_t c = 0; c < channels; ++c) {
      const scene::TransferView& function = visibility.functions[c];
      const float deviation = 0.5f * (front[c].deviation + back[c].deviation) * function.to_entry_scale;
      path[c] = {function.entry_of(front[c].value), function.entry_of(back[c].value),
                 3 * deviation * deviation};
      matter[c] = path[c].mean(function, 0, 1);
      extinction += matter[c].extinction;
      longest = std::fmax(longest, path[c].length());
    }
  }
};

/// A span's matter, front to back, and where in it what is seen is in the mean.
template <std::uint32_t kChannels>
struct SpanParts {
  int count = 1;
  scene::Matter matter[kChannels][kMostParts];
  float seen_at = 0.5f;  ///< a share of the span

  GVX_HD SpanParts(const scene::Visibility& visibility, const Span<kChannels>& span, std::uint32_t channels,
                   float units) {
    if (span.longest > kNarrowPath) {
      count = static_cast<int>(std::fmin(1 + span.extinction * units / kThinDepth, float(kMostParts)));
    }
    for (std::uint32_t c = 0; c < channels; ++c) {
      for (int part = 0; part < count; ++part) {
        matter[c][part] =
            count == 1 ? span.matter[c] : span.path[c].mean(visibility.functions[c], part, count);
      }
    }
    if (count == 1) return;
    const float share = 1 / static_cast<float>(count);
    float left = 1, moment = 0;
    for (int part = 0; part < count; ++part) {
      float extinction = 0;
      for (std::uint32_t c = 0; c < channels; ++c) extinction += matter[c][part].extinction;
      const float opacity = opacity_of(extinction * units * share);
      moment += left * opacity * (static_cast<float>(part) + 0.5f) * share;
      left *= 1 - opacity;
    }
    if (left < 1.0f) seen_at = moment / (1 - left);
  }
};

/// Adds a span that is seen, `units` unit distances long.
template <std::uint32_t kChannels, typename Voxel, int M>
GVX_HD void composite_span(const RayView& ray, const Stretch<Voxel, M>& s, const Span<kChannels>& span,
                           std::uint32_t channels, bool by_gradient, float units, RayState& state) {
  const FrameView& frame = ray.frame;
  const scene::Visibility& visibility = frame.visibility;
  const SpanParts<kChannels> parts(visibility, span, channels, units);
  const bool lit = frame.lighting.lighting.enabled;
  scene::Shade<float> shade[kChannels];
  float factor[kChannels];
  for (std::uint32_t c = 0; c < channels; ++c) factor[c] = 1;
  if (lit || by_gradient) {
    // Lit where it is seen: a surface may begin near the back end.
    const float i = s.held_in_voxel(span.centre, span.begin + parts.seen_at * (span.end - span.begin));
    const float blend = s.blend_at(frame, i);
    for (std::uint32_t c = 0; c < channels; ++c) {
      if (!(span.matter[c].extinction > 0.0f)) continue;
      const Vec3f gradient = gradient_at(s, c, i, blend);
      // Squares of very large or small values would be no numbers.
      const Vec3f relative = gradient / frame.soft_gradient[c];
      const float certainty =
          scene::surface_certainty(s.gradient_scale(frame, blend) * length(relative), 1.0f);
      shade[c] = ray.shade(relative, certainty, s.t_at(i));
      if (visibility.functions[c].gradient_factor == nullptr) continue;
      const float voxels = s.fine.voxels_across * (1 - blend) + s.coarse.voxels_across * blend;
      const Vec3f world = Vec3f(frame.world_to_tree.transposed_vector(Vec3d(gradient)));
      factor[c] = visibility.functions[c].factor_of_gradient(length(world) * voxels);
    }
  }
  for (int part = 0; part < parts.count && state.phase == RayPhase::under_way; ++part) {
    scene::Matter sum;
    for (std::uint32_t c = 0; c < channels; ++c) {
      const scene::Matter& here = parts.matter[c][part];
      if (!(here.extinction > 0.0f)) continue;
      const float weight = factor[c] * here.extinction;
      sum.color = sum.color + factor[c] * here.color * shade[c].body + weight * shade[c].glint;
      sum.extinction += weight;
    }
    if (!(sum.extinction > 0.0f)) continue;
    add(state, sum.color / sum.extinction,
        opacity_of(sum.extinction * units / static_cast<float>(parts.count)));
  }
}

template <std::uint32_t kChannels, typename Voxel, int M>
GVX_HD void composite_scalars(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  const scene::Visibility& visibility = frame.visibility;
  const std::uint32_t channels = kChannels == 1 ? 1 : visibility.channels;
  const float units = frame.units_per_tick * static_cast<float>(frame.stride[s.level]);
  bool by_gradient = false;
  for (std::uint32_t c = 0; c < channels; ++c) {
    by_gradient = by_gradient || visibility.functions[c].gradient_factor != nullptr;
  }
  const auto sample_all = [&](float i, ScalarSample* samples) {
    const float blend = s.blend_at(frame, i);
    for (std::uint32_t c = 0; c < channels; ++c) samples[c] = sample_at(s, c, i, blend);
    ++state.samples;
  };
  ScalarSample front[kChannels], back[kChannels];
  sample_all(-0.5f, front);
  for (std::int64_t step = 0; step < s.steps && state.phase == RayPhase::under_way; ++step) {
    const auto centre = static_cast<float>(step);
    const float begin = centre - 0.5f, end = centre + 0.5f;
    sample_all(end, back);
    const Span<kChannels> whole(visibility, channels, centre, begin, end, front, back);
    // Where the values change fast they do not change evenly.
    const float opaque = std::fmin(whole.extinction * units, 1.0f);
    const int cuts = static_cast<int>(std::fmin(1 + opaque * whole.longest / kWidePath, float(kMostCuts)));
    if (whole.extinction > 0.0f && cuts == 1) {
      composite_span(ray, s, whole, channels, by_gradient, units, state);
    } else if (whole.extinction > 0.0f) {
      const float share = 1 / static_cast<float>(cuts);
      for (int cut = 1; cut <= cuts && state.phase == RayPhase::under_way; ++cut) {
        ScalarSample next[kChannels];
        const float to = begin + static_cast<float>(cut) * share;
        sample_all(to, next);
        const Span<kChannels> span(visibility, channels, centre, to - share, to, front, next);
        if (span.extinction > 0.0f) {
          composite_span(ray, s, span, channels, by_gradient, units * share, state);
        }
        for (std::uint32_t c = 0; c < channels; ++c) front[c] = next[c];
      }
    }
    for (std::uint32_t c = 0; c < channels; ++c) front[c] = back[c];
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
