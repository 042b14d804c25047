/// \file
/// Lighting: Blinn-Phong shading, with the gradient of the values as normal. Both sides of a surface are lit.
/// There are no shadows.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx::scene {

enum class LightKind : std::uint32_t {
  camera,       ///< far away, in a direction relative to the camera: x right, y up, z towards the viewer
  directional,  ///< far away, in a direction of world space
  point         ///< at a position in world space; equally bright at every distance
};

struct Light {
  LightKind kind = LightKind::camera;
  Vec3d place{-0.6, 0.7, 1};  ///< direction, or position of a point light; default: over the left shoulder
  Vec3f color{1, 1, 1};

  constexpr bool operator==(const Light&) const = default;
};

/// The weights of the shading terms, and the lights. With ambient + diffuse = 1, a surface that faces a
/// single white light keeps its own colour.
struct Lighting {
  static constexpr int kMostLights = 8;

  bool enabled = true;
  float ambient = 0.25f;
  float diffuse = 0.75f;
  float specular = 0.2f;
  float shininess = 32;
  int lights = 1;
  Light light[kMostLights];

  bool has_points() const {
    bool some = false;
    for (int i = 0; i < lights; ++i) some = some || light[i].kind == LightKind::point;
    return some;
  }
  constexpr bool operator==(const Lighting&) const = default;
};

/// How certain it is that a gradient is that of a surface, from 0 to 1, and not that of noise. Both arguments
/// are in values per voxel. At `soft` the certainty is one half.
template <typename Real>
GVX_HD inline Real surface_certainty(Real gradient, Real soft) {
  const Real ratio = gradient / soft;
  const Real held = ratio < Real(1e15) ? ratio : Real(1e15);  // its square is a number
  return held * held / (held * held + 1);
}

/// A gradient for which the certainty is one half. Its unit is the range of values that the transfer function
/// distinguishes, per voxel: at a surface the values cross this range within a few voxels.
inline constexpr double kSoftGradient = 1.0 / 40;

/// What lighting does to a colour and its weight, such as its opacity: color * body + weight * glint.
template <typename Real>
struct Shade {
  Vec3<Real> body{Real(1), Real(1), Real(1)};
  Vec3<Real> glint;
};

/// Lighting for kernels: the lights of one frame in world space.
struct LightingView {
  Lighting lighting;
  Vec3d place[Lighting::kMostLights];  ///< unit directions to the lights, or positions of point lights

  /// The unit vector, or zero where there is no direction: between opposite directions, or to the point
  /// itself.
  template <typename Real>
  GVX_HD static Vec3<Real> unit_or_zero(Vec3<Real> v) {
    const Real l = length(v);
    return l > Real(0) ? v / l : Vec3<Real>();
  }

  /// Shades a point with this gradient, in world space; to_eye is a unit vector. `certainty`, 0 to 1, says
  /// how certain a surface is. Where it is 0, the point is lit equally from all sides.
  template <typename Real>
  GVX_HD Shade<Real> shade(Vec3<Real> gradient, Real certainty, Vec3<Real> to_eye, Vec3<Real> point) const {
    Shade<Real> shade;
    if (!lighting.enabled) return shade;
    const Real steepness = length(gradient);
    const bool has_normal = steepness > Real(0);
    const Vec3<Real> normal = has_normal ? gradient / steepness : gradient;
    shade.body = Vec3<Real>(Real(lighting.ambient));
    for (int i = 0; i < lighting.lights; ++i) {
      const Light& light = lighting.light[i];
      const Vec3<Real> color(light.color);
      Vec3<Real> to_light(place[i]);
      if (light.kind == LightKind::point) to_light = unit_or_zero(to_light - point);
      Real facing = Real(1);
      if (has_normal) {
        facing = Real(1) + certainty * (std::fabs(dot(normal, to_light)) - Real(1));
        const Real half = std::fabs(dot(normal, unit_or_zero(to_eye + to_light)));
        const Real glint = certainty * Real(lighting.specular) * std::pow(half, Real(lighting.shininess));
        shade.glint = shade.glint + glint * color;
      }
      shade.body = shade.body + Real(lighting.diffuse) * facing * color;
    }
    return shade;
  }
};

/// An error if a weight is not a finite number of 0 or more, or a light has no direction or position.
inline Status check(const Lighting& lighting) {
  for (const float weight : {lighting.ambient, lighting.diffuse, lighting.specular, lighting.shininess}) {
    if (!(weight >= 0) || !std::isfinite(weight)) return Error{"lighting: weights must be 0 or more"};
  }
  for (int i = 0; i < lighting.lights; ++i) {
    const Light& light = lighting.light[i];
    const double far = length(light.place);
    const bool placed = std::isfinite(far) && (light.kind == LightKind::point || far > 0);
    const bool colored = light.color.x >= 0 && light.color.y >= 0 && light.color.z >= 0 &&
                         std::isfinite(light.color.x + light.color.y + light.color.z);
    if (!placed || !colored) {
      return Error{"light " + std::to_string(i + 1) + ": must have a direction and a colour of 0 or more"};
    }
  }
  return {};
}

/// The lights in world space, for a camera with these axes.
inline LightingView place_lights(const Lighting& lighting, Vec3d forward, Vec3d right, Vec3d up) {
  LightingView view;
  view.lighting = lighting;
  for (int i = 0; i < lighting.lights; ++i) {
    const Light& light = lighting.light[i];
    const Vec3d p = light.place;
    view.place[i] = light.kind == LightKind::point ? p
                    : light.kind == LightKind::directional
                        ? normalize(p)
                        : normalize(p.x * right + p.y * up - p.z * forward);
  }
  return view;
}

}  // namespace gvx::scene
