#include "gvx/scene/transform_parts.h"

#include <cmath>
#include <numbers>

namespace gvx::scene {
namespace {

/// Rodrigues' formula.
Affine3 turn(const Rotation& rotation) {
  const Vec3d axis = normalize(rotation.axis);
  const double angle = rotation.degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
  const auto turned = [&](Vec3d v) { return c * v + s * cross(axis, v) + (1 - c) * dot(axis, v) * axis; };
  return {{turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})}, {}};
}

}  // namespace

Affine3 TransformParts::to_world() const {
  if (matrix) return *matrix;
  Affine3 map = scale ? scaling(*scale) : Affine3();
  if (rotate) map = turn(*rotate) * map;
  if (translate) map.origin = *translate;
  return map;
}

}  // namespace gvx::scene
