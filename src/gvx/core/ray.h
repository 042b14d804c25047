/// \file
/// Rays and axis-aligned boxes in double precision, and where the one crosses the other.
#pragma once

#include "gvx/core/vec.h"

namespace gvx {

/// The points origin + t*direction; the direction need not be of unit length.
struct Ray {
  Vec3d origin;
  Vec3d direction;

  GVX_HD Vec3d at(double t) const { return origin + t * direction; }
};

/// A ray may stand for all that is within a cone around it: width + growth * t wide at distance t.
struct ConeShape {
  double width = 0, growth = 0;
};

/// Closed box; empty where a minimum exceeds its maximum.
struct Box3d {
  Vec3d minimum;
  Vec3d maximum;

  GVX_HD bool empty() const {
    return !(minimum.x <= maximum.x && minimum.y <= maximum.y && minimum.z <= maximum.z);
  }
  constexpr bool operator==(const Box3d&) const = default;
};

/// The parameters [enter, exit] of a ray; empty where enter >= exit.
struct RayInterval {
  double enter = 0;
  double exit = 0;

  GVX_HD bool empty() const { return !(enter < exit); }
};

/// What is in both boxes.
inline Box3d intersect(const Box3d& a, const Box3d& b) {
  Box3d both;
  for (int axis = 0; axis < 3; ++axis) {
    both.minimum[axis] = a.minimum[axis] > b.minimum[axis] ? a.minimum[axis] : b.minimum[axis];
    both.maximum[axis] = a.maximum[axis] < b.maximum[axis] ? a.maximum[axis] : b.maximum[axis];
  }
  return both;
}

/// The part of [t_min, t_max] that is inside the box, by the slab method; a ray in the plane of a face is
/// inside.
GVX_HD inline RayInterval intersect(const Ray& ray, const Box3d& box, double t_min, double t_max) {
  RayInterval inside{t_min, t_max};
  for (int axis = 0; axis < 3; ++axis) {
    const double o = ray.origin[axis], d = ray.direction[axis];
    if (d == 0) {
      if (o < box.minimum[axis] || o > box.maximum[axis]) return {1, 0};
      continue;
    }
    double near = (box.minimum[axis] - o) / d, far = (box.maximum[axis] - o) / d;
    if (near > far) {
      const double swapped = near;
      near = far;
      far = swapped;
    }
    if (near > inside.enter) inside.enter = near;
    if (far < inside.exit) inside.exit = far;
  }
  return inside;
}

}  // namespace gvx
