/// \file
/// The passes of tile_march.h over all tiles, as templates over N. Private to this room.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "gvx/exec/parallel.h"
#include "gvx/render/tile/tile_marcher.h"

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

template <int N>
bool march_tiles(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                 exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                 exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  GVX_CHECK(pass.blank_tiles.size == grid.tiles());
  Turns turns(deadline);
  const TilesView view(pass);
  const TileProjection projection(pass.frame, 1);
  exec::parallel_for(cpu, tiles.size, [&](std::size_t t) {
    if (!turns.all_taken()) return;
    const TilePart part(grid, tiles[t]);
    if (pass.blank_tiles[tiles[t]] == pass.epoch) return;
    const auto index_of = [&](std::uint32_t x, std::uint32_t y) { return std::size_t(y) * grid.width + x; };
    const auto index_of_ray = [&](std::uint32_t i) {
      return index_of(part.x0 + i % TileRays::kEdge, part.y0 + i / TileRays::kEdge);
    };
    ActiveRays marching, resuming;
    bool all_finished = true;
    // Rays of a tile begin together: of one that is new their states, most of a frame's memory, need not be
    // waited for until they are written.
    const bool is_new =
        pass.lone_ray == Pass::kAllRays && rays[index_of(part.x0, part.y0)].epoch != pass.epoch;
    if (is_new) {
      marching = ActiveRays::all_of(part.width, part.height);
      all_finished = false;
    } else {
      part.for_rays([&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
        const RayState& ray = rays[index_of(x, y)];
        const bool begun = ray.epoch == pass.epoch;
        if (begun && ray.phase == RayPhase::finished) return;
        all_finished = false;
        if (pass.lone_ray != Pass::kAllRays && pass.lone_ray != index_of(x, y)) return;
        marching.set(i);
        if (begun) resuming.set(i);
      });
    }
    // A tile that is finished must cost next to nothing, or short frames end in it.
    if (all_finished) return;
    exec::store_relaxed(&unfinished[tiles[t]], 1);
    if (marching.count() == 0 || !turns.take()) return;
    TileMarcher<N> marcher(view, projection, part.x0, part.y0, 1, grid.tile, false);
    marcher.leave_out_all_but(marching);
    if (is_new) marcher.will_put({&rays[index_of_ray(0)], grid.width, part.width, part.height});
    resuming.for_each([&](std::uint32_t i) { marcher.resume(i, rays[index_of_ray(i)]); });
    marcher.march(deadline);
    if (is_new && marcher.is_blank()) {
      pass.blank_tiles[tiles[t]] = pass.epoch;
      return exec::store_relaxed(&unfinished[tiles[t]], 0);
    }
    bool finished = marching.count() == part.width * part.height;
    const auto done = [&](RayState& ray) {
      ray.epoch = pass.epoch;
      finished = finished && ray.phase == RayPhase::finished;
    };
    marching.for_each([&](std::uint32_t i) {
      if (marcher.is_stub(i)) return;
      RayState& ray = rays[index_of_ray(i)];
      marcher.put_state(i, ray);
      done(ray);
    });
    // Apart: beside a march a compiler makes the loop above a slow one.
    if (projects(pass.frame)) {
      marching.for_each([&](std::uint32_t i) {
        if (!marcher.is_stub(i)) return;
        RayState& ray = rays[index_of_ray(i)];
        if (ray.epoch != pass.epoch) ray = RayState{};
        const std::uint32_t x = part.x0 + i % TileRays::kEdge, y = part.y0 + i / TileRays::kEdge;
        march_ray(pass, x, y, ray);
        done(ray);
      });
    }
    if (finished) exec::store_relaxed(&unfinished[tiles[t]], 0);
  });
  return turns.all_taken();
}

template <int N>
bool preview_tiles(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                   exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline, std::uint32_t block,
                   std::uint32_t generation, exec::BufferView<const RayState> rays,
                   exec::BufferView<PreviewPixel> pixels) {
  Turns turns(deadline);
  const TilesView view(pass);
  const TileProjection projection(pass.frame, double(block));
  const exec::TileGrid film{pass.frame.width, pass.frame.height};
  exec::parallel_for(cpu, tiles.size, [&](std::size_t t) {
    if (!turns.all_taken()) return;
    const TilePart part(grid, tiles[t]);
    const auto index_of = [&](std::uint32_t x, std::uint32_t y) {
      return std::size_t(y) * block * pass.frame.width + std::size_t(x) * block;
    };
    const auto is_drawn = [&](std::uint32_t x, std::uint32_t y) {
      const bool may_be_blank = pass.blank_tiles.size > 0;
      if (may_be_blank && pass.blank_tiles[film.tile_of(x * block, y * block)] == pass.epoch) return true;
      const std::size_t pixel = index_of(x, y);
      return (rays[pixel].epoch == pass.epoch && rays[pixel].phase == RayPhase::finished) ||
             (pixels[pixel].epoch == pass.epoch && pixels[pixel].generation == generation);
    };
    ActiveRays missing;
    part.for_rays([&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
      if (!is_drawn(x, y)) missing.set(i);
    });
    if (missing.count() == 0 || !turns.take()) return;
    TileMarcher<N> marcher(view, projection, double(part.x0) * block, double(part.y0) * block, double(block),
                           grid.tile, true);
    marcher.leave_out_all_but(missing);
    // A preview's ray cannot stop half way.
    marcher.march(exec::no_deadline());
    missing.for_each([&](std::uint32_t i) {
      const std::uint32_t x = part.x0 + i % TileRays::kEdge, y = part.y0 + i / TileRays::kEdge;
      PreviewPixel& pixel = pixels[index_of(x, y)];
      if (marcher.is_stub(i)) {
        pixel = preview_ray(pass, double(x) * block, double(y) * block);
      } else {
        pixel = marcher.pixel(i);
      }
      pixel.epoch = pass.epoch;
      pixel.generation = generation;
    });
  });
  return turns.all_taken();
}

}  // namespace gvx::render
