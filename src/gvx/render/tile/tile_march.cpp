#include "gvx/render/tile/tile_march.h"

#include "gvx/render/reference/march_view.h"
#include "gvx/render/tile/tile_passes.h"

namespace gvx::render {

bool marches_tiles(const Pass& pass) {
  return !pass.one_ray_at_a_time;
}

bool tile_march(const exec::Device& cpu, const ExactMarch& march) {
  GVX_CHECK(march.grid.tile == exec::TileGrid::kTile);
  return with_children(march.pass.n, [&](auto n) { return march_tiles<decltype(n)::value>(cpu, march); });
}

bool tile_preview(const exec::Device& cpu, const PreviewMarch& march) {
  GVX_CHECK(march.grid.tile <= exec::TileGrid::kTile);
  return with_children(march.pass.n, [&](auto n) { return preview_tiles<decltype(n)::value>(cpu, march); });
}

}  // namespace gvx::render
