/// \file
/// Stretch: the steps of a ray within one node, and where they are in the bricks that hold its values. Every
/// way to look gathers from stretches (composite.h, projection.h, isosurface.h).
///
/// A step is looked at from its front end to its back end. Both lie in the brick, or in its border, when its
/// centre lies in the node: a step is no longer than a voxel. So a stretch needs no other node, and the steps
/// of a ray join without gaps whatever nodes they are in.
#pragma once

#include <cstdint>

#include "gvx/brick/brick_pool.h"
#include "gvx/render/frame/frame.h"
#include "gvx/render/frame/ray_state.h"
#include "gvx/render/reference/sample.h"

namespace gvx::render {

/// What of a ray stays the same from stretch to stretch.
struct RayView {
  const FrameView& frame;
  Ray world;
  Vec3f to_eye;

  /// The lighting at distance t, at a point with this gradient in tree space; `certainty` says how much of a
  /// surface it is.
  GVX_HD scene::Shade<float> shade(Vec3f gradient_tree, float certainty, double t) const {
    if (!frame.lighting.lighting.enabled) return {};
    const Vec3f gradient_world = Vec3f(frame.world_to_tree.transposed_vector(Vec3d(gradient_tree)));
    return frame.lighting.shade<float>(gradient_world, certainty, to_eye, Vec3f(world.at(t)));
  }
};

/// Where steps are in one brick: in voxels from its low corner.
template <typename Voxel, int M>
struct BrickPath {
  brick::BrickView<Voxel, M> brick;
  Vec3f first;  ///< the centre of the first step
  Vec3f per_step;
  float voxels_across = 0;  ///< of the brick's level, in all of tree space

  /// The place at step i, which may be a fraction: centres are whole, ends are halves.
  GVX_HD Vec3f at(float i) const { return one_lane::along(first, per_step, i); }
  GVX_HD one_lane::PlainTexels<Voxel> texels(std::uint32_t channel) const {
    return {brick.plane(channel), M};
  }
};

/// What of a stretch is the same whatever the voxels are.
struct StretchSteps {
  std::int64_t steps = 0;
  int level = 0;        ///< whose steps these are, and whose brick the fine one is
  double stride = 1;    ///< of a step, in ticks
  double t_centre = 0;  ///< of the first step
  double t_step = 0;
  bool blended = false;
  bool fine_deviates = false;        ///< the fine brick is not of the finest level
  ChannelRanges ranges;              ///< of the node's values, where these are projected
  const FrameView* noisy = nullptr;  ///< the frame, where it adds noise
  Vec3d place, place_step;           ///< then: in tree space, the first step's centre and the way of a step
};

template <typename Voxel, int M>
struct Stretch : StretchSteps {
  BrickPath<Voxel, M> fine;
  BrickPath<Voxel, M> coarse;  ///< where blended

  /// Where noise is added, and whether that may be seen at a value.
  GVX_HD bool adds_noise_at(float value) const {
    return noisy != nullptr && !noisy->visibility.hides_noise_at(value);
  }
  GVX_HD float with_noise(float value, float i) const {
    if (!adds_noise_at(value)) return value;
    return value + noisy->noise.at(double(value), place + double(i) * place_step, noisy->footprint(t_at(i)));
  }
  /// What it adds to a gradient in values a voxel.
  GVX_HD Vec3f noise_gradient(float value, Vec3f gradient, float i) const {
    Vec3f added;
    if (!adds_noise_at(value)) return added;
    const double width = noisy->footprint(t_at(i));
    const float voxels = static_cast<float>(width) * fine.voxels_across;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d half;
      half[axis] = 0.5 * width;
      const Vec3d at = place + double(i) * place_step;
      const float change = 0.5f * voxels * gradient[axis];
      added[axis] = (noisy->noise.at(double(value + change), at + half, width) -
                     noisy->noise.at(double(value - change), at - half, width)) /
                    voxels;
    }
    return added;
  }

  GVX_HD float gradient_scale(const FrameView& frame, float blend) const {
    // Gradients are told a voxel of the brick; with noise voxels count as they are seen.
    const double seen = noisy != nullptr ? noisy->footprint(t_centre) * double(fine.voxels_across) : 1;
    const float fine_scale = frame.gradient_scale[level] * static_cast<float>(seen);
    return blended ? fine_scale + blend * (frame.gradient_scale[level - 1] - fine_scale) : fine_scale;
  }
  GVX_HD float held_in_voxel(float centre, float i) const {
    return one_lane::held_in_voxel<one_lane::kMayLack<Voxel>>(fine, centre, i);
  }
  GVX_HD double t_at(float i) const { return t_centre + static_cast<double>(i) * t_step; }
  GVX_HD float blend_at(const FrameView& frame, float i) const {
    return blended ? frame.blend_at(level, t_at(i)) : 0.0f;
  }
};

/// Step i of a stretch, by itself.
template <typename Voxel, int M>
GVX_HD Stretch<Voxel, M> one_step(const Stretch<Voxel, M>& s, float i) {
  Stretch<Voxel, M> one = s;
  one.steps = 1;
  one.t_centre = s.t_at(i);
  one.fine.first = s.fine.at(i);
  one.coarse.first = s.coarse.at(i);
  one.place = s.place + double(i) * s.place_step;
  return one;
}

/// A value of one channel, and how far the finest voxels that it stands for deviate from it.
struct ScalarSample {
  float value = 0;
  float deviation = 0;
};

/// What `of` gives for the fine brick, blended with what it gives for the coarse one.
template <typename Voxel, int M, typename Of>
GVX_HD inline auto blended(const Stretch<Voxel, M>& s, float blend, const Of& of) {
  const auto fine = of(s.fine);
  return blend > 0.0f ? one_lane::mix(fine, of(s.coarse), blend) : fine;
}

template <typename Voxel, int M>
GVX_HD inline float value_at(const Stretch<Voxel, M>& s, std::uint32_t channel, float i, float blend) {
  const float value = blended(s, blend, [&](const BrickPath<Voxel, M>& path) {
    return one_lane::sample(path.texels(channel), M, path.at(i));
  });
  return s.with_noise(value, i);
}

template <typename Voxel, int M>
GVX_HD inline ScalarSample sample_at(const Stretch<Voxel, M>& s, std::uint32_t channel, float i,
                                     float blend) {
  const float deviation = blended(s, blend, [&](const BrickPath<Voxel, M>& path) {
    if (&path == &s.fine && !s.fine_deviates) return 0.0f;
    return one_lane::deviation(path.brick.deviations(channel), M, path.at(i));
  });
  return {value_at(s, channel, i, blend), deviation};
}

/// The gradient in stored values a voxel, fine and coarse blended. It takes all that the border holds, so `i`
/// must lie in the node: see held_in_voxel.
template <typename Voxel, int M>
GVX_HD inline Vec3f gradient_at(const Stretch<Voxel, M>& s, std::uint32_t channel, float i, float blend) {
  const Vec3f gradient = blended(s, blend, [&](const BrickPath<Voxel, M>& path) {
    return one_lane::gradient(path.texels(channel), M, path.at(i));
  });
  if (s.noisy == nullptr) return gradient;
  const float value = blended(s, blend, [&](const BrickPath<Voxel, M>& path) {
    return one_lane::sample(path.texels(channel), M, path.at(i));
  });
  return gradient + s.noise_gradient(value, gradient, i);
}

/// The same, and none where it would be of what is no data.
template <typename Voxel, int M>
GVX_HD inline Vec3f gradient_or_none(const Stretch<Voxel, M>& s, std::uint32_t channel, float i,
                                     float blend) {
  return one_lane::or_none<one_lane::kMayLack<Voxel>>(gradient_at(s, channel, i, blend));
}

/// Puts a colour of this opacity behind what was gathered.
GVX_HD inline void add(RayState& state, Vec3f color, float opacity) {
  one_lane::put_behind(true, color, opacity, state.color, state.opacity);
  if (state.opacity >= kOpaque) state.phase = RayPhase::finished;
}

using one_lane::opacity_of;

}  // namespace gvx::render
