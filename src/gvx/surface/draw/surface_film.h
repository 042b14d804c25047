/// \file
/// SurfaceFilm: what each ray of a film sees of opaque surfaces.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "gvx/core/vec.h"
#include "gvx/surface/draw/tile_hits.h"

namespace gvx::surface {

/// 32 bytes.
struct SurfacePixel {
  float depth = std::numeric_limits<float>::infinity();  ///< by which surfaces are compared
  std::uint32_t brick = TileHits::kNothing;              ///< of the picture's; kNothing: none is seen
  std::uint32_t item = 0;                                ///< of the brick
  float place = std::numeric_limits<float>::infinity();  ///< the depth at which the surface itself is
  Vec3f color;                                           ///< as it is displayed, once it is shaded
  std::int32_t object = -1;                              ///< whose surface it is; -1: it is not shaded yet

  bool seen() const { return brick != TileHits::kNothing; }
  bool shaded() const { return object >= 0; }
};
static_assert(sizeof(SurfacePixel) == 32);

/// For kernels: the rays of a film, row by row.
struct SurfaceFilmView {
  const SurfacePixel* pixels = nullptr;
  std::uint32_t width = 0, height = 0;

  const SurfacePixel& at(std::uint32_t x, std::uint32_t y) const { return pixels[std::size_t(y) * width + x]; }
};

}  // namespace gvx::surface
