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
#include "gvx/brick/sample.h"
#include "gvx/render/frame.h"
#include "gvx/render/ray_state.h"

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
  GVX_HD Vec3f at(float i) const { return first + i * per_step; }
};

template <typename Voxel, int M>
struct Stretch {
  std::int64_t steps = 0;
  int level = 0;        ///< whose steps these are, and whose brick the fine one is
  double t_centre = 0;  ///< of the first step
  double t_step = 0;
  BrickPath<Voxel, M> fine;
  BrickPath<Voxel, M> coarse;  ///< where blended
  bool blended = false;
  bool fine_deviates = false;  ///< the fine brick is not of the finest level

  GVX_HD float gradient_scale(const FrameView& frame, float blend) const {
    const float fine_scale = frame.gradient_scale[level];
    return blended ? fine_scale + blend * (frame.gradient_scale[level - 1] - fine_scale) : fine_scale;
  }
  GVX_HD double t_at(float i) const { return t_centre + static_cast<double>(i) * t_step; }
  GVX_HD float blend_at(const FrameView& frame, float i) const {
    return blended ? frame.blend_at(level, t_at(i)) : 0.0f;
  }
};

/// A value of one channel, and how far the finest voxels that it stands for deviate from it.
struct ScalarSample {
  float value = 0;
  float deviation = 0;
};

template <typename Voxel, int M>
GVX_HD inline float value_at(const Stretch<Voxel, M>& s, std::uint32_t channel, float i, float blend) {
  const float fine = brick::sample<M>(s.fine.brick.plane(channel), s.fine.at(i));
  if (!(blend > 0.0f)) return fine;
  const float coarse = brick::sample<M>(s.coarse.brick.plane(channel), s.coarse.at(i));
  return fine + blend * (coarse - fine);
}

template <typename Voxel, int M>
GVX_HD inline ScalarSample sample_at(const Stretch<Voxel, M>& s, std::uint32_t channel, float i,
                                     float blend) {
  ScalarSample sample{value_at(s, channel, i, blend), 0};
  if (s.fine_deviates) {
    sample.deviation = brick::deviation<M>(s.fine.brick.deviations(channel), s.fine.at(i));
  }
  if (blend > 0.0f) {
    const float coarse = brick::deviation<M>(s.coarse.brick.deviations(channel), s.coarse.at(i));
    sample.deviation += blend * (coarse - sample.deviation);
  }
  return sample;
}

/// The gradient in stored values a voxel, fine and coarse blended.
template <typename Voxel, int M>
GVX_HD inline Vec3f gradient_at(const Stretch<Voxel, M>& s, std::uint32_t channel, float i, float blend) {
  const Vec3f fine = brick::gradient<M>(s.fine.brick.plane(channel), s.fine.at(i));
  if (!(blend > 0.0f)) return fine;
  const Vec3f coarse = brick::gradient<M>(s.coarse.brick.plane(channel), s.coarse.at(i));
  return fine + blend * (coarse - fine);
}

/// A ray stops when no more than this is left to see: a quarter of a step of 8 bits.
inline constexpr float kOpaque = 1.0f - 1.0f / 1024;

/// Puts a colour of this opacity behind what was gathered.
GVX_HD inline void add(RayState& state, Vec3f color, float opacity) {
  const float weight = (1 - state.opacity) * opacity;
  state.color = state.color + weight * color;
  state.opacity += weight;
  if (state.opacity >= kOpaque) state.phase = RayPhase::finished;
}

/// The opacity of so much extinction times length.
GVX_HD inline float opacity_of(float depth) {
  return 1 - std::exp(-depth);
}

}  // namespace gvx::render
