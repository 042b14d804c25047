/// \file
/// What passes over tiles have in common: the rays of a tile that are in the picture, the pixels of a
/// preview, and which tiles begin. Private to this room.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "gvx/exec/tile_grid.h"
#include "gvx/render/march_pass.h"
#include "gvx/render/tile/tile_rays.h"

namespace gvx::render {

/// The part of a tile that is in the picture.
struct TilePart {
  std::uint32_t x0, y0, width, height;

  TilePart(exec::TileGrid grid, std::uint32_t tile)
      : x0(tile % grid.tiles_x() * grid.tile),
        y0(tile / grid.tiles_x() * grid.tile),
        width(std::min(grid.tile, grid.width - x0)),
        height(std::min(grid.tile, grid.height - y0)) {}

  /// Calls function(i, x, y) for each of its rays; i is the ray's place among those of the tile.
  template <typename Function>
  void for_rays(Function function) const {
    for (std::uint32_t j = 0; j < height; ++j) {
      for (std::uint32_t i = 0; i < width; ++i) function(j * TileRays::kEdge + i, x0 + i, y0 + j);
    }
  }
};

/// The pixels of a preview, by their places in its grid of blocks.
class PreviewPixels {
 public:
  explicit PreviewPixels(const PreviewMarch& march)
      : march_(march), film_{march.pass.film.width, march.pass.film.height} {}

  /// Is it drawn, or its exact ray finished?
  bool is_drawn(std::uint32_t x, std::uint32_t y) const {
    const Pass& pass = march_.pass;
    const bool may_be_blank = pass.blank_tiles.size > 0;
    if (may_be_blank && pass.blank_tiles[film_.tile_of(x * march_.block, y * march_.block)] == pass.epoch) {
      return true;
    }
    const RayState& ray = march_.rays[index(x, y)];
    const PreviewPixel& pixel = march_.pixels[index(x, y)];
    return (ray.epoch == pass.epoch && ray.phase == RayPhase::finished) ||
           (pixel.epoch == pass.epoch && pixel.generation == march_.generation);
  }
  void put(std::uint32_t x, std::uint32_t y, PreviewPixel drawn) const {
    drawn.epoch = march_.pass.epoch;
    drawn.generation = march_.generation;
    march_.pixels[index(x, y)] = drawn;
  }

 private:
  std::size_t index(std::uint32_t x, std::uint32_t y) const {
    return std::size_t(y) * march_.block * film_.width + std::size_t(x) * march_.block;
  }

  const PreviewMarch& march_;
  const exec::TileGrid film_;
};

/// Which tiles that have something to do begin: those before the deadline, and one in any case. However slow
/// the machine and short the frame, the next one finds more done.
class Turns {
 public:
  explicit Turns(exec::Deadline deadline) : deadline_(deadline) {}
  /// May another begin?
  bool take() {
    const bool first = !some_began_.exchange(true, std::memory_order_relaxed);
    if (first || !exec::late(deadline_)) return true;
    all_taken_.store(false, std::memory_order_relaxed);
    return false;
  }
  /// Did all that wanted to?
  bool all_taken() const { return all_taken_.load(std::memory_order_relaxed); }

 private:
  exec::Deadline deadline_;
  std::atomic<bool> some_began_{false}, all_taken_{true};
};

}  // namespace gvx::render
