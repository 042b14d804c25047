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
#include <limits>
#include <optional>

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "gvx/render/frame/frame.h"
#include "gvx/render/vectors/sample_simd-inl.h"
#include "gvx/render/vectors/simd_targets.h"

HWY_BEFORE_NAMESPACE();
namespace gvx::render::HWY_NAMESPACE {
namespace {

#include "gvx/render/formula/colors.inc"

/// scene::Shade.
struct Shade {
  Vec3v body, glint;
};

HWY_INLINE Vec3v unit_or_zero(const Vec3v& v) {
  const Float length2 = dot(v, v);
  const Mask some = hn::Gt(length2, hn::Zero(kFloats));
  return scaled(hn::IfThenElseZero(some, hn::Div(all(1), hn::Sqrt(hn::IfThenElse(some, length2, all(1))))),
                v);
}
/// What of shading is the same for all rays of a batch. kWhole: gradients are of whole numbers, the squares
/// of which no float overflows.
template <bool kWhole>
class Shading {
 public:
  HWY_INLINE explicit Shading(const FrameView& frame)
      : frame_(frame),
        lighting_(frame.lighting.lighting),
        to_tree_{Vec3f(frame.world_to_tree.column[0]), Vec3f(frame.world_to_tree.column[1]),
                 Vec3f(frame.world_to_tree.column[2])} {
    const Vec3f& square = frame.gradient_square;
    for (std::uint32_t c = 0; c < kMaxChannels; ++c) per_soft_gradient_[c] = 1 / frame.soft_gradient[c];
    even_ = square.x == square.y && square.y == square.z && !mixes_axes();
    for (int l = 0; l < lighting_.lights; ++l) {
      const scene::Light& light = lighting_.light[l];
      gray_ = gray_ && light.color.x == light.color.y && light.color.y == light.color.z;
      place_[l] = Vec3f(frame.lighting.place[l]);
      if (light.kind != scene::LightKind::point) {
        to_light_[l] = Vec3f(frame.world_to_tree.vector(frame.lighting.place[l]));
      }
    }
    const float exponent = lighting_.shininess;
    constexpr float kMostMultiplied = 256;
    if (exponent == std::floor(exponent) && exponent <= kMostMultiplied) {
      whole_exponent_ = static_cast<unsigned>(exponent);
    }
  }

  bool lit() const { return lighting_.enabled; }
  /// Is there but one light, far away and without a hue?
  bool by_one() const {
    return gray_ && lighting_.lights == 1 && lighting_.light[0].kind != scene::LightKind::point;
  }

  /// What is the same all along a ray: in tree space, the directions half way between far lights and the eye.
  struct FarHalves {
    Vec3v of_light[scene::Lighting::kMostLights];
  };
  HWY_INLINE void find_halves(const Vec3v& to_eye, FarHalves& halves) const {
    for (int l = 0; l < lighting_.lights; ++l) {
      if (lighting_.light[l].kind == scene::LightKind::point) continue;
      halves.of_light[l] = to_tree(between(to_eye, all_of(place_[l])));
    }
  }

  /// The square of a gradient's length in the world.
  HWY_INLINE Float world_length2(const Vec3v& gradient) const {
    const Vec3f& square = frame_.gradient_square;
    if (even_) return hn::Mul(all(square.x), dot(gradient, gradient));
    const auto term = [](float factor, Float a, Float b)
                          HWY_ATTR { return hn::Mul(hn::Mul(all(factor), a), b); };
    Float sum = term(square.x, gradient.x, gradient.x);
    sum = hn::MulAdd(hn::Mul(all(square.y), gradient.y), gradient.y, sum);
    sum = hn::MulAdd(hn::Mul(all(square.z), gradient.z), gradient.z, sum);
    if (mixes_axes()) {
      const Vec3f& product = frame_.gradient_product;
      sum = hn::Add(sum, term(product.x, gradient.y, gradient.z));
      sum = hn::Add(sum, term(product.y, gradient.z, gradient.x));
      sum = hn::Add(sum, term(product.z, gradient.x, gradient.y));
    }
    return sum;
  }

  /// RayView::shade with a gradient of a channel in tree space, in stored values a voxel; `scale` is
  /// FrameView::gradient_scale. `point_at()` gives the place in the world, where a light is near.
  template <typename PointAt>
  HWY_INLINE Shade shade(std::uint32_t channel, const Vec3v& gradient, Float scale, const Vec3v& to_eye,
                         const FarHalves& halves, const PointAt& point_at) const {
    const Float per_soft = all(per_soft_gradient_[channel]);
    if constexpr (kWhole) return shade_scaled(gradient, hn::Mul(scale, per_soft), to_eye, halves, point_at);
    return shade_scaled(scaled(per_soft, gradient), scale, to_eye, halves, point_at);
  }

  /// The same of the first channel by_one(): the shade's x, which is its y and z. In one piece, without the
  /// loops and branches of any lights: a vector's numbers stay in registers.
  HWY_INLINE void shade_by_one(const Vec3v& gradient, Float scale, const FarHalves& halves, Float& body,
                               Float& glint) const {
    static_assert(kWhole);
    Float per_length, certain;
    measure(gradient, hn::Mul(scale, all(per_soft_gradient_[0])), per_length, certain);
    const auto cosine = [&](const Vec3v& direction)
                            HWY_ATTR { return hn::Mul(hn::Abs(dot(gradient, direction)), per_length); };
    const Float color = all(lighting_.light[0].color.x), diffuse = all(lighting_.diffuse);
    const Float facing = cosine(all_of(to_light_[0])), half_way = cosine(halves.of_light[0]);
    // What is no surface faces every light.
    const Float lit = hn::MulAdd(hn::Mul(certain, diffuse), hn::Sub(facing, all(1)), diffuse);
    body = hn::MulAdd(lit, color, all(lighting_.ambient));
    glint = hn::Mul(hn::Mul(hn::Mul(certain, all(lighting_.specular)), shine(half_way)), color);
  }

  /// RayView::shade: `certainty`, 0 to 1, says how much of a surface it is.
  template <typename PointAt>
  HWY_INLINE Shade shade_certain(const Vec3v& gradient, Float certainty, const Vec3v& to_eye,
                                 const FarHalves& halves, const PointAt& point_at) const {
    const Float length2 = world_length2(gradient), zero = hn::Zero(kFloats);
    const Mask some = hn::Gt(length2, zero);
    const Float per_length = hn::Div(all(1), hn::Sqrt(hn::IfThenElse(some, length2, all(1))));
    return shade_unit(gradient, per_length, hn::IfThenElse(some, certainty, zero), to_eye, halves, point_at);
  }

 private:
  /// The same as shade(), by what makes the gradient one in units of what is half a surface. (No copies of
  /// vectors here: a compiler makes them in halves, for which whole loads wait.)
  template <typename PointAt>
  HWY_INLINE Shade shade_scaled(const Vec3v& gradient, Float scale, const Vec3v& to_eye,
                                const FarHalves& halves, const PointAt& point_at) const {
    Float per_length, certain;
    measure(gradient, scale, per_length, certain);
    return shade_unit(gradient, per_length, certain, to_eye, halves, point_at);
  }

  HWY_INLINE void measure(const Vec3v& gradient, Float scale, Float& per_length, Float& certain) const {
    // What is certainly a surface, and what has no normal and is none: more and less would be no numbers.
    constexpr float kCertain = 1e15f, kFlat = std::numeric_limits<float>::min();
    const Float steep2 = hn::Min(hn::Mul(hn::Mul(scale, scale), dot(gradient, gradient)), all(kCertain));
    const Float steepness = hn::Sqrt(hn::Max(world_length2(gradient), all(kFlat)));
    // One division for two: of steep2 / (steep2 + 1), the certainty, and of 1 / steepness. (Approximations
    // and a step of Newton's take longer: what divides does nothing else.)
    const Float above = hn::Add(steep2, all(1));
    const Float both = hn::Div(all(1), hn::Mul(above, steepness));
    per_length = hn::Mul(above, both);
    certain = hn::Mul(hn::Mul(steep2, steepness), both);
  }

  /// `per_length` makes the gradient one of unit length in the world.
  template <typename PointAt>
  HWY_INLINE Shade shade_unit(const Vec3v& gradient, const Float& per_length, const Float& certain,
                              const Vec3v& to_eye, const FarHalves& halves, const PointAt& point_at) const {
    const Float diffuse = hn::Mul(certain, all(lighting_.diffuse));
    const Float specular = hn::Mul(certain, all(lighting_.specular));
    const Float ambient = all(lighting_.ambient), zero = hn::Zero(kFloats);
    Shade shade{{ambient, ambient, ambient}, {zero, zero, zero}};
    for (int l = 0; l < lighting_.lights; ++l) {
      const scene::Light& light = lighting_.light[l];
      const auto cosine = [&](const Vec3v& direction)
                              HWY_ATTR { return hn::Mul(hn::Abs(dot(gradient, direction)), per_length); };
      Float facing, half_way;
      if (light.kind == scene::LightKind::point) {
        const Vec3v point = point_at(), place = all_of(place_[l]);
        const Vec3v direction =
            unit_or_zero({hn::Sub(place.x, point.x), hn::Sub(place.y, point.y), hn::Sub(place.z, point.z)});
        facing = cosine(to_tree(direction));
        half_way = cosine(to_tree(between(to_eye, direction)));
      } else {
        facing = cosine(all_of(to_light_[l]));
        half_way = cosine(halves.of_light[l]);
      }
      // What is no surface faces every light.
      const Float body = hn::MulAdd(diffuse, hn::Sub(facing, all(1)), all(lighting_.diffuse));
      const Float glint = hn::Mul(specular, shine(half_way));
      const auto add = [&](float color, Float& to_body, Float& to_glint) HWY_ATTR {
        to_body = hn::MulAdd(body, all(color), to_body);
        to_glint = hn::MulAdd(glint, all(color), to_glint);
      };
      add(light.color.x, shade.body.x, shade.glint.x);
      if (gray_) continue;
      add(light.color.y, shade.body.y, shade.glint.y);
      add(light.color.z, shade.body.z, shade.glint.z);
    }
    if (gray_) {
      shade.body.y = shade.body.z = shade.body.x;
      shade.glint.y = shade.glint.z = shade.glint.x;
    }
    return shade;
  }

  HWY_INLINE static Vec3v all_of(const Vec3f& v) { return {all(v.x), all(v.y), all(v.z)}; }
  HWY_INLINE static Vec3v between(const Vec3v& to_eye, const Vec3v& to_light) {
    return unit_or_zero(
        {hn::Add(to_eye.x, to_light.x), hn::Add(to_eye.y, to_light.y), hn::Add(to_eye.z, to_light.z)});
  }

  /// A direction of the world in tree space, where its product with a gradient is that of the world's.
  HWY_INLINE Vec3v to_tree(const Vec3v& direction) const {
    const auto along_axis = [&](int axis) HWY_ATTR {
      return dot({all(to_tree_[0][axis]), all(to_tree_[1][axis]), all(to_tree_[2][axis])}, direction);
    };
    return {along_axis(0), along_axis(1), along_axis(2)};
  }

  HWY_INLINE bool mixes_axes() const {
    const Vec3f& product = frame_.gradient_product;
    return product.x != 0 || product.y != 0 || product.z != 0;
  }

  /// A cosine to the power of the shininess.
  HWY_INLINE Float shine(Float base) const {
    if (!whole_exponent_) {
      constexpr float kLeast = 1e-30f;  // the logarithm of nothing would be none
      const Float logarithm = hn::Log(kFloats, hn::Max(base, all(kLeast)));
      return hn::Exp(kFloats, hn::Mul(all(lighting_.shininess), logarithm));
    }
    unsigned left = *whole_exponent_;
    if (left == 0) return all(1);
    for (; left % 2 == 0; left /= 2) base = hn::Mul(base, base);
    Float power = base;
    while ((left /= 2) != 0) {
      base = hn::Mul(base, base);
      if (left % 2 != 0) power = hn::Mul(power, base);
    }
    return power;
  }

  const FrameView& frame_;
  const scene::Lighting& lighting_;
  float per_soft_gradient_[kMaxChannels];
  const Vec3f to_tree_[3];  // columns
  Vec3f place_[scene::Lighting::kMostLights], to_light_[scene::Lighting::kMostLights];
  bool even_, gray_ = true;  // voxels as wide along every axis; lights without a hue
  std::optional<unsigned> whole_exponent_;
};

}  // namespace
}  // namespace gvx::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
