/// \file
/// SurfaceFilmView: what each ray of a film sees of opaque surfaces.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gvx/core/macros.h"
#include "gvx/core/vec.h"

namespace gvx::surface {

/// 32 bytes.
struct SurfacePixel {
  static constexpr std::uint32_t kNothing = UINT32_MAX;

  float depth = INFINITY;          ///< along the view, by which surfaces are compared
  std::uint32_t brick = kNothing;  ///< of the picture's; kNothing: none is seen
  std::uint32_t item = 0;          ///< of the brick
  float place = INFINITY;          ///< the depth at which the surface itself is
  Vec3f color;                     ///< as it is displayed, once it is shaded
  std::int32_t object = -1;        ///< whose surface it is; -1: it is not shaded yet

  GVX_HD bool seen() const { return brick != kNothing; }
  GVX_HD bool shaded() const { return object >= 0; }
};
static_assert(sizeof(SurfacePixel) == 32);

/// For kernels: the rays of a film, row by row. Where nothing of a tile was drawn, its pixels say nothing.
struct SurfaceFilmView {
  static constexpr std::uint32_t kTile = 64;

  const SurfacePixel* pixels = nullptr;
  const std::uint8_t* tiles = nullptr;  ///< not 0: drawn
  std::uint32_t width = 0, height = 0;

  GVX_HD bool empty() const { return pixels == nullptr; }
  GVX_HD SurfacePixel at(std::uint32_t x, std::uint32_t y) const {
    const std::uint32_t tile = y / kTile * ((width + kTile - 1) / kTile) + x / kTile;
    return tiles[tile] != 0 ? pixels[std::size_t(y) * width + x] : SurfacePixel();
  }
};

}  // namespace gvx::surface
