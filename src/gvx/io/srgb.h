/// \file
/// Channels of colours as displayed and in linear light, 0 to 1 (sRGB, IEC 61966-2-1).
#pragma once

#include <cmath>

namespace gvx::io {

/// From a display value to linear light.
inline double to_linear(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/// From linear light to a display value.
inline double to_display(double v) {
  return v <= 0.0031308 ? v * 12.92 : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

}  // namespace gvx::io
