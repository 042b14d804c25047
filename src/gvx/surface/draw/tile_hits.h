/// \file
/// TileHits: what is seen in a tile of the film so far: of each pixel the nearest sample or triangle of all
/// bricks that were drawn (a visibility buffer: Burns and Hunt 2013). Colours are found later, for what is
/// seen in the end.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "gvx/surface/cell_set.h"
#include "gvx/surface/draw/placed_brick.h"
#include "gvx/surface/draw/surface_film_view.h"

namespace gvx::surface {

/// A cell as a number.
GVX_HD constexpr std::uint32_t packed(Cell cell) {
  return static_cast<std::uint32_t>(cell.x + kCells * (cell.y + kCells * cell.z));
}
GVX_HD constexpr Cell unpacked(std::uint32_t item) {
  return {static_cast<int>(item % kCells), static_cast<int>(item / kCells % kCells),
          static_cast<int>(item / (kCells * kCells) % kCells)};
}

struct TileHits {
  static constexpr std::int32_t kEdge = 64;
  static constexpr std::uint32_t kNothing = SurfacePixel::kNothing;

  PixelRect rect;                       ///< of the film
  const std::uint64_t* keys = nullptr;  ///< of each brick: in which order they win where depths are equal
  /// Vectors that begin in the last row may end beyond it.
  static constexpr std::int32_t kPixels = kEdge * kEdge + 64;

  float depth[kPixels];
  std::uint32_t brick[kPixels];  ///< kNothing: none is seen
  std::uint32_t item[kPixels];   ///< of the brick: a packed cell, or the number of a triangle

  std::size_t index(std::int32_t x, std::int32_t y) const {
    const std::int32_t at = (y - rect.y0) * kEdge + (x - rect.x0);
    return static_cast<std::size_t>(at);
  }
  void clear(const PixelRect& of_film, const std::uint64_t* of_bricks) {
    rect = of_film;
    keys = of_bricks;
    std::fill(std::begin(depth), std::end(depth), std::numeric_limits<float>::infinity());
    std::fill(std::begin(brick), std::end(brick), kNothing);
  }

  /// Puts what a brick shows at a pixel where it is nearer. At equal depth the lower key of a brick wins,
  /// then the lower item: so the order of drawing makes no difference.
  void put(std::size_t pixel, float at, std::uint32_t of_brick, std::uint32_t of_item) {
    if (!(at <= depth[pixel])) return;
    if (at == depth[pixel]) {
      const std::uint32_t other = brick[pixel];
      if (other == kNothing) return;  // infinitely far
      const bool before =
          keys[of_brick] != keys[other] ? keys[of_brick] < keys[other] : of_item < item[pixel];
      if (!before) return;
    }
    depth[pixel] = at;
    brick[pixel] = of_brick;
    item[pixel] = of_item;
  }

  /// Is something nearer than `nearest` in all pixels of a rectangle of the tile?
  bool hides(const PixelRect& part, double nearest) const {
    const auto at = static_cast<float>(nearest);
    for (std::int32_t y = part.y0; y < part.y1; ++y) {
      const float* row = depth + index(part.x0, y);
      float most = 0;
      for (std::int32_t i = 0; i < part.x1 - part.x0; ++i) most = std::max(most, row[i]);
      if (!(most < at)) return false;
    }
    return true;
  }
};

}  // namespace gvx::surface
