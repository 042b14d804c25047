/// \file
/// Lighting: Blinn-Phong on the gradient. Both sides of a surface are lit; there are no shadows.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx::scene {

enum class LightKind : std::uint32_t {
  camera,       ///< far away, in a direction that goes with the camera: x right, y up, z towards the viewer
  directional,  ///< far away, in a direction of the world
  point         ///< at a place of the world, as bright at every distance
};

struct Light {
  LightKind kind = LightKind::camera;
  Vec3d place{-0.6, 0.7, 1};  ///< the direction to the light, or its place; by default over the left shoulder
  Vec3f color{1, 1, 1};

  constexpr bool operator==(const Light&) const = default;
};

/// Weights of the terms, and the lights; ambient + diffuse = 1 keeps a surface that faces one white light at
/// its own colour.
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

/// How much of a surface matter with this gradient is, 0 to 1. Both in values a voxel; `soft` is where it is
/// half of one: noise has gradients too, but none that mean anything.
template <typename Real>
GVX_HD inline Real surface_certainty(Real gradient, Real soft) {
  const Real ratio = gradient / soft;
  const Real held = ratio < Real(1e15) ? ratio : Real(1e15);  // its square is a number
  return held * held / (held * held + 1);
}

/// A surface crosses the values that a transfer function tells apart within a few voxels; this share of them
/// a voxel counts half.
inline constexpr double kSoftGradient = 1.0 / 40;

/// What lighting does to a colour of some weight (its opacity, say): color * body + weight * glint.
template <typename Real>
struct Shade {
  Vec3<Real> body{Real(1), Real(1), Real(1)};
  Vec3<Real> glint;
};

/// Lighting as kernels take it: the lights of one frame in world space.
struct LightingView {
  Lighting lighting;
  Vec3d place[Lighting::kMostLights];  ///< unit directions to the lights, or places of point lights

  /// A light opposite the eye has no direction half way, and one at the point itself none at all.
  template <typename Real>
  GVX_HD static Vec3<Real> unit_or_zero(Vec3<Real> v) {
    const Real l = length(v);
    return l > Real(0) ? v / l : Vec3<Real>();
  }

  /// At a point with this gradient, in world space; to_eye is a unit vector. `certainty`, 0 to 1, says how
  /// much of a surface it is: homogeneous matter has no normal and is lit from all sides alike.
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

/// An error where a weight is no number, or a light has no direction or place.
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

/// The lights where they are in a frame whose camera has these axes.
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
