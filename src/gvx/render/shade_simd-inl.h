/// \file
/// Lighting in vectors: scene::LightingView once more, the same names mean the same.
/// Compiled once for each instruction set.

// Passed as often as there are instruction sets, so no #pragma once.
#if defined(GVX_RENDER_SHADE_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GVX_RENDER_SHADE_SIMD_INL_H
#undef GVX_RENDER_SHADE_SIMD_INL_H
#else
#define GVX_RENDER_SHADE_SIMD_INL_H
#endif

#include <cmath>

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "gvx/render/sample_simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

/// scene::Shade.
struct Shade {
  Vec3v body, glint;
};

HWY_INLINE Vec3v scaled(Float s, const Vec3v& v) {
  return {hn::Mul(s, v.x), hn::Mul(s, v.y), hn::Mul(s, v.z)};
}
HWY_INLINE Vec3v unit_or_zero(const Vec3v& v) {
  const Float length2 = dot(v, v);
  const Mask some = hn::Gt(length2, hn::Zero(kFloats));
  return scaled(hn::IfThenElseZero(some, hn::Div(all(1), hn::Sqrt(hn::IfThenElse(some, length2, all(1))))),
                v);
}
HWY_INLINE Float power_of(Float base, float exponent) {
  constexpr float kMostMultiplied = 256;
  if (exponent == std::floor(exponent) && exponent <= kMostMultiplied) {
    Float result = all(1);
    for (auto left = static_cast<unsigned>(exponent); left != 0; left >>= 1) {
      if ((left & 1) != 0) result = hn::Mul(result, base);
      base = hn::Mul(base, base);
    }
    return result;
  }
  constexpr float kLeast = 1e-30f;  // the logarithm of nothing would be none
  return hn::Exp(kFloats, hn::Mul(all(exponent), hn::Log(kFloats, hn::Max(base, all(kLeast)))));
}

/// A gradient of tree space in the world.
HWY_INLINE Vec3v to_world(const FrameView& frame, const Vec3v& gradient) {
  const auto along_axis = [&](int axis) HWY_ATTR {
    const Vec3f column(frame.world_to_tree.column[axis]);
    return dot({all(column.x), all(column.y), all(column.z)}, gradient);
  };
  return {along_axis(0), along_axis(1), along_axis(2)};
}

/// What of shading is the same all along a ray: the directions half way between the eye and lights that are
/// far.
class Halfways {
 public:
  HWY_INLINE void find(const scene::LightingView& lighting, const Vec3v& to_eye) {
    for (int l = 0; l < lighting.lighting.lights; ++l) {
      if (lighting.lighting.light[l].kind == scene::LightKind::point) continue;
      const Vec3f place(lighting.place[l]);
      direction_[l] = between(to_eye, {all(place.x), all(place.y), all(place.z)});
    }
  }
  HWY_INLINE const Vec3v& operator[](int light) const { return direction_[light]; }

  HWY_INLINE static Vec3v between(const Vec3v& to_eye, const Vec3v& to_light) {
    return unit_or_zero(
        {hn::Add(to_eye.x, to_light.x), hn::Add(to_eye.y, to_light.y), hn::Add(to_eye.z, to_light.z)});
  }

 private:
  Vec3v direction_[scene::Lighting::kMostLights];
};

/// RayView::shade with a gradient in tree space, in units of what is half a surface; `scale` is
/// FrameView::gradient_scale. `point_at()` gives the place in the world, where a light is near.
template <typename PointAt>
HWY_INLINE Shade shade(const FrameView& frame, const Vec3v& gradient, Float scale, const Vec3v& to_eye,
                       const Halfways& halfways, const PointAt& point_at) {
  const Float zero = hn::Zero(kFloats), one = all(1);
  const Float steep2 = hn::Min(hn::Mul(hn::Mul(scale, scale), dot(gradient, gradient)), all(1e30f));
  const Float certainty = hn::Div(steep2, hn::Add(steep2, one));
  const Vec3v world = to_world(frame, gradient);
  const Float steepness = hn::Sqrt(dot(world, world));
  // Where there is no normal, all of it is 0.
  const Float per_length = hn::IfThenElseZero(hn::Gt(steepness, zero), hn::Div(one, steepness));
  const Float certain = hn::IfThenElseZero(hn::Gt(steepness, zero), certainty);
  const scene::Lighting& lighting = frame.lighting.lighting;
  const Float ambient = all(lighting.ambient), specular = hn::Mul(certain, all(lighting.specular));
  Shade shade{{ambient, ambient, ambient}, {zero, zero, zero}};
  for (int l = 0; l < lighting.lights; ++l) {
    const scene::Light& light = lighting.light[l];
    const Vec3f place(frame.lighting.place[l]);
    Vec3v to_light = {all(place.x), all(place.y), all(place.z)};
    Vec3v half;
    if (light.kind == scene::LightKind::point) {
      const Vec3v point = point_at();
      to_light = unit_or_zero(
          {hn::Sub(to_light.x, point.x), hn::Sub(to_light.y, point.y), hn::Sub(to_light.z, point.z)});
      half = Halfways::between(to_eye, to_light);
    } else {
      half = halfways[l];
    }
    const auto cosine = [&](const Vec3v& direction)
                            HWY_ATTR { return hn::Mul(hn::Abs(dot(world, direction)), per_length); };
    const Float facing = hn::MulAdd(certain, hn::Sub(cosine(to_light), one), one);
    const Float glint = hn::Mul(specular, power_of(cosine(half), lighting.shininess));
    const Float diffuse = hn::Mul(all(lighting.diffuse), facing);
    const Float r = all(light.color.x), g = all(light.color.y), b = all(light.color.z);
    shade.body = {hn::MulAdd(diffuse, r, shade.body.x), hn::MulAdd(diffuse, g, shade.body.y),
                  hn::MulAdd(diffuse, b, shade.body.z)};
    shade.glint = {hn::MulAdd(glint, r, shade.glint.x), hn::MulAdd(glint, g, shade.glint.y),
                   hn::MulAdd(glint, b, shade.glint.z)};
  }
  return shade;
}

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
