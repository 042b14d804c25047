/// \file
/// ObjectRay: the ray of a pixel as an object's tree sees it, and what of it is in the object.
#pragma once

#include <cstddef>

#include "gvx/core/ray.h"
#include "gvx/render/frame/frame.h"

namespace gvx::render {

struct ObjectRay {
  Ray world;
  Ray tree;            ///< from the eye; t is the distance in the world
  RayInterval inside;  ///< the visible volume, as far as a proxy leaves it; ticks count from where it begins
  double first_tick = 0;  ///< of what a proxy leaves

  GVX_HD ObjectRay(const FrameView& frame, double pixel_x, double pixel_y)
      : world(frame.camera.pixel_ray(pixel_x, pixel_y)) {
    const Ray from_eye = frame.camera.pixel_ray_from_eye(pixel_x, pixel_y);
    tree = {frame.world_to_tree.vector(from_eye.origin), frame.world_to_tree.vector(from_eye.direction)};
    inside = intersect(tree, frame.box, 0, 1e300);
    if (frame.proxy != nullptr && !inside.empty()) {
      const auto x = static_cast<std::size_t>(pixel_x), y = static_cast<std::size_t>(pixel_y);
      first_tick = frame.cut(frame.proxy[y * frame.width + x], inside);
    }
  }
};

}  // namespace gvx::render
