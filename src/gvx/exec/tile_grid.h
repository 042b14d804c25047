/// \file
/// How a picture is cut into tiles, and when work on it must stop: what both launchers and their callers
/// name.
#pragma once

#include <chrono>
#include <cstdint>

#include "gvx/core/macros.h"

namespace gvx::exec {

/// When work that can be cut short must stop; no_deadline() never comes.
using Deadline = std::chrono::steady_clock::time_point;
inline Deadline no_deadline() {
  return Deadline::max();
}

/// Has it come?
inline bool late(Deadline deadline) {
  return deadline != no_deadline() && std::chrono::steady_clock::now() >= deadline;
}

/// An image and the square tiles that it is worked on in; tiles at the right and lower edge may be cut.
struct TileGrid {
  static constexpr std::uint32_t kTile = 64;

  std::uint32_t width = 0, height = 0;
  std::uint32_t tile = kTile;

  GVX_HD std::uint32_t tiles_x() const { return (width + tile - 1) / tile; }
  GVX_HD std::uint32_t tiles_y() const { return (height + tile - 1) / tile; }
  GVX_HD std::uint32_t tiles() const { return tiles_x() * tiles_y(); }
  /// The tile that holds a pixel.
  GVX_HD std::uint32_t tile_of(std::uint32_t x, std::uint32_t y) const {
    return y / tile * tiles_x() + x / tile;
  }
};

}  // namespace gvx::exec
