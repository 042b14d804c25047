#include "gvx/render/tile/tile_march.h"

#include "gvx/render/reference/march_view.h"
#include "gvx/render/tile/tile_passes.h"

namespace gvx::render {

bool marches_tiles(const Pass& pass) {
  return !pass.one_ray_at_a_time;
}

bool tile_march(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  GVX_CHECK(grid.tile == exec::TileGrid::kTile);
  return with_children(pass.n, [&](auto n) {
    return march_tiles<decltype(n)::value>(cpu, pass, grid, tiles, deadline, rays, unfinished);
  });
}

bool tile_preview(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                  exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline, std::uint32_t block,
                  std::uint32_t generation, exec::BufferView<const RayState> rays,
                  exec::BufferView<PreviewPixel> pixels) {
  GVX_CHECK(grid.tile <= exec::TileGrid::kTile);
  return with_children(pass.n, [&](auto n) {
    return preview_tiles<decltype(n)::value>(cpu, pass, grid, tiles, deadline, block, generation, rays,
                                             pixels);
  });
}

}  // namespace gvx::render
