#include "gvx/render/tile_march.h"

#include "gvx/render/tile_passes.h"

namespace gvx::render {

GVX_INSTANTIATE_TILE_MARCH(extern, std::uint8_t)
GVX_INSTANTIATE_TILE_MARCH(extern, std::uint16_t)
GVX_INSTANTIATE_TILE_MARCH(extern, float)

bool marches_tiles(const Pass& pass) {
  return !pass.one_ray_at_a_time;
}

bool tile_march(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  GVX_CHECK(grid.tile == exec::TileGrid::kTile);
  return with_voxel_type(pass.frame.format.type, [&](auto zero) {
    return march_tiles_of<decltype(zero)>(cpu, pass, grid, tiles, deadline, rays, unfinished);
  });
}

bool tile_preview(const exec::Device& cpu, const Pass& pass, exec::TileGrid grid,
                  exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline, std::uint32_t block,
                  std::uint32_t generation, exec::BufferView<const RayState> rays,
                  exec::BufferView<PreviewPixel> pixels) {
  GVX_CHECK(grid.tile <= exec::TileGrid::kTile);
  return with_voxel_type(pass.frame.format.type, [&](auto zero) {
    return preview_tiles_of<decltype(zero)>(cpu, pass, grid, tiles, deadline, block, generation, rays,
                                            pixels);
  });
}

}  // namespace gvx::render
