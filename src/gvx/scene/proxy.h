/// \file
/// Proxy: a closed surface around all that may be seen of a volume. Rays march only between the first and the
/// last place where they cross it (section 5.1 of the 2008 report: "proxy surfaces"). mesh/mesh_proxy.h makes
/// one of a mesh.
#pragma once

#include "gvx/core/ray.h"

namespace gvx::scene {

/// All functions are called from several threads at once. Places and rays are those of tree space, in which
/// the volume's tree is the cube [0, 1]^3.
class Proxy {
 public:
  virtual ~Proxy() = default;

  /// Is a place inside?
  virtual bool inside(Vec3d place) const = 0;

  /// The part of a ray from the first crossing, or its origin if that is inside, to the last; empty where
  /// there is none.
  virtual RayInterval span(const Ray& ray, bool origin_inside) const = 0;
};

}  // namespace gvx::scene
