/// \file
/// SampleAttributes: what is known of the surface in a cell beside its place: a normal and a colour, 6 bytes.
///
/// The normal's octahedral coordinates (Meyer, Suessmuth, Sussner, Stamminger 2010), -1 to 1 as 0 to 4095,
/// are a number of 24 bits, x in the upper twelve; its bytes stand least first.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/core/macros.h"
#include "gvx/core/vec.h"

namespace gvx::surface {

struct SampleAttributes {
  std::uint8_t normal[3] = {};  ///< octahedral; see below
  std::uint8_t color[3] = {};   ///< red, green, blue as displayed

  constexpr bool operator==(const SampleAttributes&) const = default;
};

/// Of a normal of unit length, and a colour of 0 to 1.
GVX_HD inline SampleAttributes pack(Vec3f normal, Vec3f color) {
  constexpr float kMost = 4095;
  const float sum = std::fabs(normal.x) + std::fabs(normal.y) + std::fabs(normal.z);
  float x = normal.x / sum, y = normal.y / sum;
  if (normal.z < 0) {
    const float folded = (1 - std::fabs(y)) * (x < 0 ? -1.0f : 1.0f);
    y = (1 - std::fabs(x)) * (y < 0 ? -1.0f : 1.0f);
    x = folded;
  }
  const auto twelve = [&](float v) {
    return static_cast<std::uint32_t>(std::lround((0.5f * v + 0.5f) * kMost));
  };
  const std::uint32_t bits = twelve(x) << 12 | twelve(y);
  SampleAttributes packed;
  for (int i = 0; i < 3; ++i) {
    packed.normal[i] = static_cast<std::uint8_t>(bits >> 8 * i);
    const float c = color[i] > 0 ? (color[i] < 1 ? color[i] : 1.0f) : 0.0f;
    packed.color[i] = static_cast<std::uint8_t>(std::lround(255 * c));
  }
  return packed;
}

GVX_HD inline Vec3f normal_of(const SampleAttributes& packed) {
  const std::uint32_t bits = packed.normal[0] | packed.normal[1] << 8 | packed.normal[2] << 16;
  const auto unit = [](std::uint32_t v) { return static_cast<float>(v) * (2.0f / 4095) - 1; };
  float x = unit(bits >> 12), y = unit(bits & 4095);
  const float z = 1 - std::fabs(x) - std::fabs(y);
  if (z < 0) {
    const float unfolded = (1 - std::fabs(y)) * (x < 0 ? -1.0f : 1.0f);
    y = (1 - std::fabs(x)) * (y < 0 ? -1.0f : 1.0f);
    x = unfolded;
  }
  return normalize(Vec3f(x, y, z));
}

GVX_HD inline Vec3f color_of(const SampleAttributes& packed) {
  return Vec3f(float(packed.color[0]), float(packed.color[1]), float(packed.color[2])) * (1.0f / 255);
}

}  // namespace gvx::surface
