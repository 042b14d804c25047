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

/// A direction of the world in tree space, where its product with a gradient is that of the world's.
HWY_INLINE Vec3v to_tree(const FrameView& frame, const Vec3v& direction) {
  const auto along_axis = [&](int axis) HWY_ATTR {
    const Affine3& m = frame.world_to_tree;
    return dot({all(static_cast<float>(m.column[0][axis])), all(static_cast<float>(m.column[1][axis])),
                all(static_cast<float>(m.column[2][axis]))},
               direction);
  };
  return {along_axis(0), along_axis(1), along_axis(2)};
}

/// The square of a gradient's length in the world.
HWY_INLINE Float world_length2(const FrameView& frame, const Vec3v& gradient) {
  const auto& square = frame.gradient_square;
  const auto& product = frame.gradient_product;
  const auto term = [](float factor, Float a, Float b)
                        HWY_ATTR { return hn::Mul(hn::Mul(all(factor), a), b); };
  Float sum = term(square.x, gradient.x, gradient.x);
  sum = hn::MulAdd(hn::Mul(all(square.y), gradient.y), gradient.y, sum);
  sum = hn::MulAdd(hn::Mul(all(square.z), gradient.z), gradient.z, sum);
  if (product.x != 0 || product.y != 0 || product.z != 0) {
    sum = hn::Add(sum, term(product.x, gradient.y, gradient.z));
    sum = hn::Add(sum, term(product.y, gradient.z, gradient.x));
    sum = hn::Add(sum, term(product.z, gradient.x, gradient.y));
  }
  return sum;
}

/// What of shading is the same all along a ray: in tree space, the directions to lights that are far, and
/// those half way between them and the eye.
class FarLights {
 public:
  HWY_INLINE void find(const FrameView& frame, const Vec3v& to_eye) {
    for (int l = 0; l < frame.lighting.lighting.lights; ++l) {
      if (frame.lighting.lighting.light[l].kind == scene::LightKind::point) continue;
      const Vec3f place(frame.lighting.place[l]);
      const Vec3v to_light{all(place.x), all(place.y), all(place.z)};
      to_light_[l] = to_tree(frame, to_light);
      half_[l] = to_tree(frame, between(to_eye, to_light));
    }
  }
  HWY_INLINE const Vec3v& to_light(int light) const { return to_light_[light]; }
  HWY_INLINE const Vec3v& half(int light) const { return half_[light]; }

  HWY_INLINE static Vec3v between(const Vec3v& to_eye, const Vec3v& to_light) {
    return unit_or_zero(
        {hn::Add(to_eye.x, to_light.x), hn::Add(to_eye.y, to_light.y), hn::Add(to_eye.z, to_light.z)});
  }

 private:
  Vec3v to_light_[scene::Lighting::kMostLights], half_[scene::Lighting::kMostLights];
};

/// RayView::shade with a gradient in tree space, in units of what is half a surface; `scale` is
/// FrameView::gradient_scale. `point_at()` gives the place in the world, where a light is near.
template <typename PointAt>
HWY_INLINE Shade shade(const FrameView& frame, const Vec3v& gradient, Float scale, const Vec3v& to_eye,
                       const FarLights& far_lights, const PointAt& point_at) {
  const Float zero = hn::Zero(kFloats), one = all(1);
  constexpr float kCertain = 1e15f;  // as a steepness squared: more would only overflow
  const Float steep2 = hn::Min(hn::Mul(hn::Mul(scale, scale), dot(gradient, gradient)), all(kCertain));
  const Float steepness = hn::Sqrt(world_length2(frame, gradient));
  // Where there is no normal, all of it is 0. One division for two: of steep2 / (steep2 + 1), the certainty,
  // and of 1 / steepness.
  const Mask some = hn::Gt(steepness, zero);
  const Float above = hn::Add(steep2, one);
  const Float both = hn::Div(one, hn::IfThenElse(some, hn::Mul(above, steepness), one));
  const Float per_length = hn::IfThenElseZero(some, hn::Mul(above, both));
  const Float certain = hn::IfThenElseZero(some, hn::Mul(hn::Mul(steep2, steepness), both));
  const scene::Lighting& lighting = frame.lighting.lighting;
  const Float ambient = all(lighting.ambient), specular = hn::Mul(certain, all(lighting.specular));
  Shade shade{{ambient, ambient, ambient}, {zero, zero, zero}};
  for (int l = 0; l < lighting.lights; ++l) {
    const scene::Light& light = lighting.light[l];
    Vec3v to_light = far_lights.to_light(l), half = far_lights.half(l);
    if (light.kind == scene::LightKind::point) {
      const Vec3f place(frame.lighting.place[l]);
      const Vec3v point = point_at();
      const Vec3v direction = unit_or_zero(
          {hn::Sub(all(place.x), point.x), hn::Sub(all(place.y), point.y), hn::Sub(all(place.z), point.z)});
      to_light = to_tree(frame, direction);
      half = to_tree(frame, FarLights::between(to_eye, direction));
    }
    const auto cosine = [&](const Vec3v& direction)
                            HWY_ATTR { return hn::Mul(hn::Abs(dot(gradient, direction)), per_length); };
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
