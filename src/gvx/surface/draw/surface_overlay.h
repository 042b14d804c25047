/// \file
/// Overlay: what the colours of surfaces say, in place of their own.
#pragma once

#include <cstdint>

namespace gvx::surface {

enum class Overlay : std::uint8_t {
  none,
  technique,  ///< by which technique a pixel was drawn: rasterised red, cast green, splatted blue
  samples  ///< of samples in the column of its cell: one green, one span of several blue, several spans red
};

/// The names of Overlay, in its order.
inline constexpr const char* kOverlayNames[] = {"none", "technique", "samples"};

}  // namespace gvx::surface
