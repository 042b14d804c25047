#include "gvx/render/tile/tile_march.h"

#include "gvx/render/reference/march_view.h"
#include "gvx/render/tile/tile_passes.h"

namespace gvx::render {

bool marches_tiles(const Pass& pass) {
  return !pass.one_ray_at_a_time;
}

bool tile_march(const exec::Device& cpu, const ExactMarch& march) {
  GVX_CHECK(march.grid.tile == exec::TileGrid::kTile);
  return with_children(march.pass.object().n,
                       [&](auto n) { return march_tiles<decltype(n)::value>(cpu, march); });
}

bool tile_preview(const exec::Device& cpu, const PreviewMarch& march) {
  GVX_CHECK(march.grid.tile <= exec::TileGrid::kTile);
  return with_children(march.pass.object().n,
                       [&](auto n) { return preview_tiles<decltype(n)::value>(cpu, march); });
}

namespace {

template <int N>
ActiveRays march_object_of(const Pass& pass, const ObjectView& object, const RaysOfTile& tile,
                           const ActiveRays& rays, RayState* states, PreviewPixel* pixels,
                           exec::Deadline deadline) {
  const TilesView view(pass, object);
  const TileProjection projection(pass.film.camera, object.frame.world_to_tree, tile.apart);
  TileMarcher<N> marcher(view, projection, tile);
  MarchingRays<N>& marching = marcher.rays();
  marching.leave_out_all_but(rays);
  rays.for_each([&](std::uint32_t i) {
    if (states[i].tick > 0 || states[i].opacity > 0.0f) marching.resume(i, states[i]);
  });
  marcher.march(deadline);
  ActiveRays stubs;
  rays.for_each([&](std::uint32_t i) {
    if (marching.is_stub(i)) return stubs.set(i);
    const RayState before = states[i];
    marching.put_state(i, states[i]);
    states[i].segment = before.segment;
    states[i].epoch = before.epoch;
    if (pixels != nullptr) pixels[i].add_counts(marching.pixel(i));
  });
  return stubs;
}

}  // namespace

ActiveRays march_object(const Pass& pass, const ObjectView& object, const RaysOfTile& tile,
                        const ActiveRays& rays, RayState* states, PreviewPixel* pixels,
                        exec::Deadline deadline) {
  return with_children(object.n, [&](auto n) {
    return march_object_of<decltype(n)::value>(pass, object, tile, rays, states, pixels, deadline);
  });
}

}  // namespace gvx::render
