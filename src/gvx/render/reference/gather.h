/// \file
/// What a ray gathers from a stretch of steps, by the frame's way to look and the voxels' content.
#pragma once

#include <type_traits>

#include "gvx/render/reference/classified.h"
#include "gvx/render/reference/composite.h"
#include "gvx/render/reference/isosurface.h"
#include "gvx/render/reference/post_classified.h"
#include "gvx/render/reference/projection.h"
#include "gvx/tree/node_pool.h"

namespace gvx::render {

/// Does a ray gather values, of which a colour is made at its end?
GVX_HD inline bool projects(const FrameView& frame) {
  return scene::projects(frame.visibility.mode);
}

/// Can nothing below a node change what a projecting ray has gathered?
GVX_HD inline bool outdone(const FrameView& frame, const tree::NodePoolView& nodes, NodeIndex node,
                           RayState& state) {
  if (!projects(frame)) return false;
  bool all = true;
  for (std::uint32_t c = 0; c < frame.visibility.channels; ++c) {
    all = all && outdone(frame.visibility.mode, state, c, frame.visibility.widened(nodes.range_of(node, c)));
  }
  return all;
}

/// From a brick.
template <typename Voxel, int M>
GVX_HD void gather_stretch(const RayView& ray, const Stretch<Voxel, M>& s, RayState& state) {
  const FrameView& frame = ray.frame;
  if constexpr (std::is_same_v<Voxel, std::uint8_t>) {
    if (frame.format.content == VoxelContent::color) return composite_colors<false>(ray, s, state);
    if (frame.format.content == VoxelContent::color_normal) return composite_colors<true>(ray, s, state);
  }
  if constexpr (!std::is_same_v<Voxel, float>) {
    if (frame.format.content == VoxelContent::labels) return composite_labels(ray, s, state);
  }
  if (projects(frame)) return project_stretch(ray, s, state);
  if (frame.visibility.mode == scene::Mode::isosurface) return find_surface(ray, s, state);
  if (frame.classification == scene::Classification::post) return composite_post(ray, s, state);
  if (frame.visibility.channels == 1) return composite_scalars<1>(ray, s, state);
  composite_scalars<kMaxChannels>(ray, s, state);
}

/// From a node of one value a channel, in steps of this stride.
GVX_HD inline void gather_constant(const RayView& ray, const ChannelRanges& values, double stride,
                                   std::int64_t steps, RayState& state) {
  const FrameView& frame = ray.frame;
  if (frame.format.content == VoxelContent::labels) {
    composite_label(ray, values.channel[0].minimum, stride, steps, state);
  } else if (projects(frame)) {
    project_constant(ray, values, stride, steps, state);
  } else if (frame.visibility.mode == scene::Mode::composite) {
    composite_constant(ray, values, stride, steps, state);
  }
}

}  // namespace gvx::render
