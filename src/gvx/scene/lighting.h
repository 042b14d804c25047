/// \file
/// Lighting: Blinn-Phong on the gradient, from one distant light that goes with the camera.
#pragma once

#include <cmath>

#include "gvx/core/vec.h"

namespace gvx::scene {

/// Weights of the terms; ambient + diffuse = 1 keeps a surface that faces the light at its own colour.
struct Lighting {
  bool enabled = true;
  float ambient = 0.25f;
  float diffuse = 0.75f;
  float specular = 0.2f;
  float shininess = 32;

  constexpr bool operator==(const Lighting&) const = default;
};

/// The direction to the light: over the viewer's left shoulder.
GVX_HD inline Vec3d direction_to_light(Vec3d forward, Vec3d right, Vec3d up) {
  return normalize(-forward - 0.6 * right + 0.7 * up);
}

/// A colour lit at a point with this world-space gradient. `certainty`, 0 to 1, says how much of a surface it
/// is: homogeneous matter has no normal and keeps its colour. Both sides of a surface are lit.
template <typename Real>
GVX_HD inline Vec3<Real> shade(const Lighting& lighting, Vec3<Real> color, Vec3<Real> gradient,
                               Real certainty, Vec3<Real> to_eye, Vec3<Real> to_light) {
  const Real gradient_length = length(gradient);
  if (!(gradient_length > Real(0))) return color;
  const Vec3<Real> normal = gradient / gradient_length;
  const Vec3<Real> halfway = normalize(to_eye + to_light);
  const Real facing = std::fabs(dot(normal, to_light));
  const Real glint = std::pow(std::fabs(dot(normal, halfway)), Real(lighting.shininess));
  const Real body = Real(lighting.ambient) + Real(lighting.diffuse) * facing;
  const Real flat = Real(lighting.ambient) + Real(lighting.diffuse);
  return color * (flat + certainty * (body - flat)) + Vec3<Real>(certainty * Real(lighting.specular) * glint);
}

}  // namespace gvx::scene
