/// \file
/// The passes of tile_march.h over all tiles, as templates over N. Private to this room.
#pragma once

#include <cstdint>

#include "gvx/exec/parallel.h"
#include "gvx/render/tile/tile_marcher.h"
#include "gvx/render/tile/tile_part.h"

namespace gvx::render {

template <int N>
bool march_tiles(const exec::Device& cpu, const ExactMarch& march) {
  const Pass& pass = march.pass;
  const exec::TileGrid grid = march.grid;
  const exec::BufferView<RayState> rays = march.rays;
  GVX_CHECK(pass.blank_tiles.size == grid.tiles());
  Turns turns(march.deadline);
  const FrameView& frame = pass.object().frame;
  const TilesView view(pass, pass.object());
  const TileProjection projection(pass.film.camera, frame.world_to_tree, 1);
  exec::parallel_for(cpu, march.tiles.size, [&](std::size_t t) {
    if (!turns.all_taken()) return;
    const std::uint32_t tile = march.tiles[t];
    const TilePart part(grid, tile);
    if (pass.blank_tiles[tile] == pass.epoch) return;
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
    exec::store_relaxed(&march.unfinished[tile], 1);
    if (marching.count() == 0 || !turns.take()) return;
    TileMarcher<N> marcher(
        view, projection,
        RaysOfTile{double(part.x0), double(part.y0), 1, part.width, part.height, grid.tile});
    MarchingRays<N>& marching_rays = marcher.rays();
    marching_rays.leave_out_all_but(marching);
    if (is_new) marching_rays.will_put({&rays[index_of_ray(0)], grid.width, part.width, part.height});
    resuming.for_each([&](std::uint32_t i) { marching_rays.resume(i, rays[index_of_ray(i)]); });
    marcher.march(march.deadline);
    if (is_new && marching_rays.is_blank()) {
      pass.blank_tiles[tile] = pass.epoch;
      return exec::store_relaxed(&march.unfinished[tile], 0);
    }
    bool finished = marching.count() == part.width * part.height;
    const auto done = [&](RayState& ray) {
      ray.epoch = pass.epoch;
      finished = finished && ray.phase == RayPhase::finished;
    };
    marching.for_each([&](std::uint32_t i) {
      if (marching_rays.is_stub(i)) return;
      RayState& ray = rays[index_of_ray(i)];
      marching_rays.put_state(i, ray);
      done(ray);
    });
    // Apart: beside a march a compiler makes the loop above a slow one.
    if (projects(frame)) {
      marching.for_each([&](std::uint32_t i) {
        if (!marching_rays.is_stub(i)) return;
        RayState& ray = rays[index_of_ray(i)];
        if (ray.epoch != pass.epoch) ray = RayState{};
        const std::uint32_t x = part.x0 + i % TileRays::kEdge, y = part.y0 + i / TileRays::kEdge;
        march_ray(pass, x, y, ray);
        done(ray);
      });
    }
    if (finished) exec::store_relaxed(&march.unfinished[tile], 0);
  });
  return turns.all_taken();
}

template <int N>
bool preview_tiles(const exec::Device& cpu, const PreviewMarch& march) {
  const Pass& pass = march.pass;
  const std::uint32_t block = march.block;
  Turns turns(march.deadline);
  const TilesView view(pass, pass.object());
  const TileProjection projection(pass.film.camera, pass.object().frame.world_to_tree, double(block));
  const PreviewPixels pixels(march);
  exec::parallel_for(cpu, march.tiles.size, [&](std::size_t t) {
    if (!turns.all_taken()) return;
    const TilePart part(march.grid, march.tiles[t]);
    ActiveRays missing;
    part.for_rays([&](std::uint32_t i, std::uint32_t x, std::uint32_t y) {
      if (!pixels.is_drawn(x, y)) missing.set(i);
    });
    if (missing.count() == 0 || !turns.take()) return;
    const double apart = block;
    TileMarcher<N> marcher(
        view, projection,
        RaysOfTile{part.x0 * apart, part.y0 * apart, apart, part.width, part.height, march.grid.tile, true});
    MarchingRays<N>& rays = marcher.rays();
    rays.leave_out_all_but(missing);
    // A preview's ray cannot stop half way.
    marcher.march(exec::no_deadline());
    missing.for_each([&](std::uint32_t i) {
      const std::uint32_t x = part.x0 + i % TileRays::kEdge, y = part.y0 + i / TileRays::kEdge;
      const bool is_stub = rays.is_stub(i);
      pixels.put(x, y, is_stub ? preview_ray(pass, double(x) * block, double(y) * block) : rays.pixel(i));
    });
  });
  return turns.all_taken();
}

}  // namespace gvx::render
