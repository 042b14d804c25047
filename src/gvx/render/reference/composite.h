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

#include "gvx/render/reference/stretch.h"

namespace gvx::render {

/// The entries of a transfer function that a channel goes through between two places.
struct EntryPath {
  float from = 0, to = 0;
  float variance3 = 0;  ///< three times the variance around it

  /// The mean matter of the part of it between two shares of its length; nothing where an end is no data.
  GVX_HD scene::Matter mean(const scene::TransferView& function, float begin, float end) const {
    if (std::isnan(from) || std::isnan(to)) return {};
    const float a = from + begin * (to - from), b = end < 1 ? from + end * (to - from) : to;
    if (!(variance3 > 0.0f)) return function.mean(a, b);
    const float centre = 0.5f * (a + b);
    const float half = std::sqrt(variance3 + 0.25f * (b - a) * (b - a));
    return function.mean(centre - half, centre + half);
  }
};

/// Something cut into pieces of one length, and a last one that may be shorter: what comes of them is then
/// continuous in what asks for them, and a rounding error there changes next to nothing.
struct Pieces {
  float number;  ///< so many times a piece's length is all

  /// As many as asked for or one more; that one grows with the first quarter of what is asked for beyond.
  GVX_HD static Pieces asked(float wanted, float most) {
    const float held = std::fmin(std::fmax(wanted, 1.0f), most), whole = std::floor(held);
    return {whole + std::fmin(4 * (held - whole), 1.0f)};
  }

  /// Where piece `index` ends, as a share of the whole; the last ends it.
  GVX_HD float end(int index) const {
    const auto next = static_cast<float>(index + 1);
    return next < number ? next / number : 1;
  }
  /// Is there a piece of this index?
  GVX_HD bool has(int index) const { return static_cast<float>(index) < number; }
};

// A step is sampled at more places the more it adds to what is seen and the farther it goes through the
// function: one for each time that it goes through this many 4096ths of it, where it hides all.
inline constexpr float kWidePath = 4.0f;
inline constexpr float kMostCuts = 8.0f;
// Between two samples, a span that goes through more 4096ths than this is cut into parts: one for each time
// that it adds kThinDepth, if it goes through twice as many or more.
inline constexpr float kNarrowPath = 8.0f;
inline constexpr float kThinDepth = 0.25f;
inline constexpr float kMostParts = 8.0f;

/// How a step is cut that adds this much to what is seen, at most 1, and goes so far through the function.
GVX_HD inline Pieces cuts_of(float adds, float longest) {
  return Pieces::asked(adds * longest / kWidePath, kMostCuts);
}
/// How a span between two samples is cut.
GVX_HD inline Pieces parts_of(float adds, float longest) {
  const float wide = std::fmin(std::fmax(longest / kNarrowPath - 1, 0.0f), 1.0f);
  return Pieces::asked(wide * adds / kThinDepth, kMostParts);
}

/// A part of a step, or all of it, between two samples of each channel. kChannels is 1, or the most there can
/// be: then the frame says how many there are.
template <std::uint32_t kChannels>
struct Span {
  float centre;      ///< of its step
  float begin, end;  ///< in steps
  EntryPath path[kChannels];
  scene::Matter matter[kChannels];
  float extinction = 0;
  float longest = 0;  ///< way that a channel goes through its function (TransferView::length)

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
      longest = std::fmax(longest, function.length(path[c].from, path[c].to));
    }
  }
};

/// What is seen of a span, and of which channel, before it is lit.
template <std::uint32_t kChannels>
struct Seen {
  Vec3f color[kChannels];
  float weight[kChannels] = {};
  float total = 0, moment = 0;

  GVX_HD float middle() const { return moment / total; }
};

/// At a place, the gradients of the channels that are seen.
template <std::uint32_t kChannels, typename Voxel, int M>
struct Slopes {
  float i = 0, blend = 0;
  Vec3f gradient[kChannels];

  GVX_HD Slopes(const FrameView& frame, const Stretch<Voxel, M>& s, const Span<kChannels>& span,
                std::uint32_t channels, float i_)
      : i(i_), blend(s.blend_at(frame, i_)) {
    for (std::uint32_t c = 0; c < channels; ++c) {
      if (span.matter[c].extinction > 0.0f) gradient[c] = gradient_or_none(s, c, i, blend);
    }
  }

  /// What channel c's extinction is multiplied by.
  GVX_HD float factor(const FrameView& frame, const Stretch<Voxel, M>& s, std::uint32_t c) const {
    const scene::TransferView& function = frame.visibility.functions[c];
    if (function.gradient_factor == nullptr) return 1;
    const float voxels = s.fine.voxels_across * (1 - blend) + s.coarse.voxels_across * blend;
    const Vec3f world = Vec3f(frame.world_to_tree.transposed_vector(Vec3d(gradient[c])));
    return function.factor_of_gradient(length(world) * voxels);
  }
  GVX_HD scene::Shade<float> shade(const RayView& ray, const Stretch<Voxel, M>& s, std::uint32_t c) const {
    // Squares of very large or small values would be no numbers.
    const Vec3f relative = gradient[c] / ray.frame.soft_gradient[c];
    const float certainty =
        scene::surface_certainty(s.gradient_scale(ray.frame, blend) * length(relative), 1.0f);
    return ray.shade(relative, certainty, s.t_at(i));
  }
};

/// Adds what is seen of a span, `units` unit distances long, but its light.
template <std::uint32_t kChannels>
GVX_HD void see_span(const scene::Visibility& visibility, const Span<kChannels>& span, std::uint32_t channels,
                     const float (&factor)[kChannels], float units, Seen<kChannels>& seen, RayState& state) {
  const Pieces parts = parts_of((1 - state.opacity) * span.extinction * units, span.longest);
  float begin = 0;
  for (int part = 0; parts.has(part); ++part) {
    const float end = parts.end(part), share = end - begin, middle = 0.5f * (begin + end);
    scene::Matter matter[kChannels];
    float extinction = 0;
    for (std::uint32_t c = 0; c < channels; ++c) {
      matter[c] = parts.has(1) ? span.path[c].mean(visibility.functions[c], begin, end) : span.matter[c];
      matter[c].color = factor[c] * matter[c].color;
      matter[c].extinction *= factor[c];
      extinction += matter[c].extinction;
    }
    begin = end;
    if (!(extinction > 0.0f)) continue;
    const float weight = (1 - state.opacity) * opacity_of(extinction * units * share);
    const float of_color = weight / extinction;
    for (std::uint32_t c = 0; c < channels; ++c) {
      seen.color[c] = seen.color[c] + of_color * matter[c].color;
      seen.weight[c] += of_color * matter[c].extinction;
    }
    seen.total += weight;
    seen.moment += weight * (span.begin + middle * (span.end - span.begin));
    state.opacity += weight;
    if (state.opacity >= kOpaque) {
      state.phase = RayPhase::finished;
      return;
    }
  }
}

/// Adds the colours of what is seen.
template <std::uint32_t kChannels, typename Voxel, int M>
GVX_HD void add_lit(const RayView& ray, const Stretch<Voxel, M>& s, std::uint32_t channels,
                    const Slopes<kChannels, Voxel, M>* slopes, const Seen<kChannels>& seen, RayState& state) {
  for (std::uint32_t c = 0; c < channels; ++c) {
    if (!(seen.weight[c] > 0.0f)) continue;
    const scene::Shade<float> shade = slopes != nullptr ? slopes->shade(ray, s, c) : scene::Shade<float>();
    state.color = state.color + seen.color[c] * shade.body + seen.weight[c] * shade.glint;
  }
}

template <std::uint32_t kChannels, typename Voxel, int M>
GVX_HD void composite_scalars(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  const scene::Visibility& visibility = frame.visibility;
  const std::uint32_t channels = kChannels == 1 ? 1 : visibility.channels;
  const float units = frame.units_per_tick * static_cast<float>(s.stride);
  const bool lit = frame.lighting.lighting.enabled;
  bool by_gradient = false;
  for (std::uint32_t c = 0; c < channels; ++c) {
    by_gradient = by_gradient || visibility.functions[c].gradient_factor != nullptr;
  }
  const auto sample_all = [&](float i, ScalarSample* samples) {
    const float blend = s.blend_at(frame, i);
    for (std::uint32_t c = 0; c < channels; ++c) samples[c] = sample_at(s, c, i, blend);
    ++state.samples;
  };
  const auto see = [&](const Span<kChannels>& span, float span_units) {
    if (!(span.extinction > 0.0f)) return;
    Seen<kChannels> seen;
    float factor[kChannels];
    for (std::uint32_t c = 0; c < channels; ++c) factor[c] = 1;
    if (by_gradient) {
      const float middle = 0.5f * (span.begin + span.end);
      const Slopes<kChannels, Voxel, M> slopes(frame, s, span, channels,
                                               s.held_in_voxel(span.centre, middle));
      for (std::uint32_t c = 0; c < channels; ++c) factor[c] = slopes.factor(frame, s, c);
      see_span(visibility, span, channels, factor, span_units, seen, state);
      return add_lit(ray, s, channels, lit ? &slopes : nullptr, seen, state);
    }
    see_span(visibility, span, channels, factor, span_units, seen, state);
    if (!(seen.total > 0.0f)) return;
    if (!lit) return add_lit<kChannels, Voxel, M>(ray, s, channels, nullptr, seen, state);
    // Lit where it is seen: a surface may begin near the back end.
    const float i = s.held_in_voxel(span.centre, seen.middle());
    const Slopes<kChannels, Voxel, M> slopes(frame, s, span, channels, i);
    add_lit(ray, s, channels, &slopes, seen, state);
  };
  ScalarSample front[kChannels], back[kChannels];
  sample_all(-0.5f, front);
  for (std::int64_t step = 0; step < s.steps && state.phase == RayPhase::under_way; ++step) {
    const auto centre = static_cast<float>(step);
    const float begin = centre - 0.5f, end = centre + 0.5f;
    sample_all(end, back);
    const Span<kChannels> whole(visibility, channels, centre, begin, end, front, back);
    // Where the values change fast they do not change evenly.
    const float adds = (1 - state.opacity) * std::fmin(whole.extinction * units, 1.0f);
    const Pieces cuts = cuts_of(adds, whole.longest);
    if (whole.extinction > 0.0f && !cuts.has(1)) {
      see(whole, units);
    } else if (whole.extinction > 0.0f) {
      float from = begin;
      for (int cut = 0; cuts.has(cut) && state.phase == RayPhase::under_way; ++cut) {
        ScalarSample next[kChannels];
        const float to = begin + cuts.end(cut);
        sample_all(to, next);
        see(Span<kChannels>(visibility, channels, centre, from, to, front, next), units * (to - from));
        from = to;
        for (std::uint32_t c = 0; c < channels; ++c) front[c] = next[c];
      }
    }
    for (std::uint32_t c = 0; c < channels; ++c) front[c] = back[c];
  }
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
    const float factor = function.gradient_factor != nullptr ? function.factor_of_gradient(0) : 1.0f;
    sum.color = sum.color + factor * m.color * shade.body;
    sum.extinction += factor * m.extinction;
  }
  ++state.samples;
  if (!(sum.extinction > 0.0f)) return;
  const float units = frame.units_per_tick * static_cast<float>(stride);
  add(state, sum.color / sum.extinction, opacity_of(sum.extinction * units * static_cast<float>(steps)));
}

}  // namespace gvx::render
