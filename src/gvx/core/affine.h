/// \file
/// Affine3: an affine map from one space to another, such as from voxels to the world. A 3x4 matrix of
/// doubles.
#pragma once

#include <cmath>

#include "gvx/core/double_double.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx {

/// Maps p to x*column[0] + y*column[1] + z*column[2] + origin.
struct Affine3 {
  Vec3d column[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Vec3d origin;

  GVX_HD Vec3d point(Vec3d p) const { return vector(p) + origin; }
  GVX_HD Vec3d vector(Vec3d v) const { return v.x * column[0] + v.y * column[1] + v.z * column[2]; }
  /// The transposed linear part times v. Maps a gradient in the target space to the source space.
  GVX_HD Vec3d transposed_vector(Vec3d v) const {
    return {dot(column[0], v), dot(column[1], v), dot(column[2], v)};
  }

  constexpr bool operator==(const Affine3&) const = default;
};

/// The image of a place, with all its digits.
inline Vec3dd point(const Affine3& map, Vec3dd p) {
  return p.x * Vec3dd(map.column[0]) + p.y * Vec3dd(map.column[1]) + p.z * Vec3dd(map.column[2]) +
         Vec3dd(map.origin);
}

/// The signed volume of the unit cube's image. If it is zero, there is no inverse.
inline double determinant(const Affine3& a) {
  return dot(a.column[0], cross(a.column[1], a.column[2]));
}

/// An error if the map has no usable inverse, or stretches one axis more than a million times as much as
/// another. Such a volume would be invisible, or a ray would never reach its end.
inline Status check_placement(const Affine3& a) {
  double least = INFINITY, most = 0;
  for (const Vec3d& column : a.column) {
    least = std::fmin(least, length(column));
    most = std::fmax(most, length(column));
  }
  const double d = std::fabs(determinant(a)) / (most * most * most);
  const bool sound =
      least > 1e-100 && most < 1e100 && most <= 1e6 * least && d > 1e-18 && std::isfinite(length(a.origin));
  if (!sound) return Error{"the volume's placement in the world has no usable inverse"};
  return {};
}

/// First b, then a: maps p to a.point(b.point(p)).
inline Affine3 operator*(const Affine3& a, const Affine3& b) {
  return {{a.vector(b.column[0]), a.vector(b.column[1]), a.vector(b.column[2])}, a.point(b.origin)};
}

/// The inverse map. The determinant must not be zero.
inline Affine3 inverse(const Affine3& a) {
  const double d = determinant(a);
  GVX_CHECK(d != 0);
  const Vec3d r0 = cross(a.column[1], a.column[2]) / d;
  const Vec3d r1 = cross(a.column[2], a.column[0]) / d;
  const Vec3d r2 = cross(a.column[0], a.column[1]) / d;
  Affine3 inverted{{{r0.x, r1.x, r2.x}, {r0.y, r1.y, r2.y}, {r0.z, r1.z, r2.z}}, {}};
  inverted.origin = -inverted.vector(a.origin);
  return inverted;
}

/// Scales each axis: maps p to p*s.
inline Affine3 scaling(Vec3d s) {
  return {{{s.x, 0, 0}, {0, s.y, 0}, {0, 0, s.z}}, {}};
}

}  // namespace gvx
