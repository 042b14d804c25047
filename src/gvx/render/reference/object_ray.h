/// \file
/// ObjectRay: a ray of a bundle as an object's tree sees it, and what of it is in the object.
#pragma once

#include "gvx/core/ray.h"
#include "gvx/render/frame/bundle_view.h"
#include "gvx/render/frame/frame.h"

namespace gvx::render {

struct ObjectRay {
  Ray world;
  Ray tree;            ///< from the bundle's origin; t is the distance in the world
  RayInterval inside;  ///< the visible volume, as far as a proxy leaves it; ticks count from where it begins
  double first_tick = 0;  ///< of what a proxy leaves

  GVX_HD ObjectRay(const FrameView& frame, const BundleRay& from_origin)
      : world{frame.bundle.origin_world + from_origin.ray.origin, from_origin.ray.direction},
        tree{frame.world_to_tree.vector(from_origin.ray.origin),
             frame.world_to_tree.vector(from_origin.ray.direction)} {
    inside = intersect(tree, frame.bundle.box, 0, 1e300);
    if (from_origin.seen != nullptr && !inside.empty()) first_tick = frame.cut(*from_origin.seen, inside);
  }
};

}  // namespace gvx::render
