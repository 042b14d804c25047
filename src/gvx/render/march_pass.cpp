#include "gvx/render/march_pass.h"

#include <string>

#include "gvx/render/reference/march_kernels.h"
#include "gvx/render/tile/tile_march.h"

namespace gvx::render {
namespace kernels {

GVX_INSTANTIATE_MARCH(extern, std::uint8_t)
GVX_INSTANTIATE_MARCH(extern, std::uint16_t)
GVX_INSTANTIATE_MARCH(extern, float)

}  // namespace kernels

Status check_kernels(const exec::Device& device, VoxelType type, std::uint32_t n, std::uint32_t m) {
  if (device.kind() == exec::DeviceKind::cpu) return {};
  // A type for which there are none was compiled for the CPU alone.
  bool there = false;
#if defined(GVX_CUDA_u8)
  there = there || type == VoxelType::u8;
#endif
#if defined(GVX_CUDA_u16)
  there = there || type == VoxelType::u16;
#endif
#if defined(GVX_CUDA_f32)
  there = there || type == VoxelType::f32;
#endif
  if (there && !has_kernels(n, m)) {
    return Error{
        "this gvx was built with CUDA kernels for trees of N = 2 and M = 16 alone; build it with "
        "-DGVX_CUDA_SHAPES=all"};
  }
  if (there) return {};
  return Error{std::string("this gvx was built without CUDA kernels for voxels of ") + voxel_name(type) +
               "; build it with that type in GVX_CUDA_VOXELS"};
}

bool march_exact(const exec::Device& device, const Pass& pass, exec::TileGrid grid,
                 exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                 exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  if (device.kind() == exec::DeviceKind::cpu && marches_tiles(pass)) {
    return tile_march(device, pass, grid, tiles, deadline, rays, unfinished);
  }
  return with_voxel_type(pass.frame.format.type, [&](auto zero) {
    return kernels::march_exact<decltype(zero)>(device, pass, grid, tiles, deadline, rays, unfinished);
  });
}

bool march_preview(const exec::Device& device, const Pass& pass, exec::TileGrid grid,
                   exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline, std::uint32_t block,
                   std::uint32_t generation, exec::BufferView<const RayState> rays,
                   exec::BufferView<PreviewPixel> pixels) {
  if (device.kind() == exec::DeviceKind::cpu && marches_tiles(pass)) {
    return tile_preview(device, pass, grid, tiles, deadline, block, generation, rays, pixels);
  }
  return with_voxel_type(pass.frame.format.type, [&](auto zero) {
    return kernels::march_preview<decltype(zero)>(device, pass, grid, tiles, deadline, block, generation,
                                                  rays, pixels);
  });
}

void march_ray(const Pass& pass, double x, double y, RayState& state) {
  with_voxel_type(pass.frame.format.type,
                  [&](auto zero) { kernels::march_ray<decltype(zero)>(pass, x, y, state); });
}

double distance_to(const Pass& pass, double x, double y, float opacity) {
  return with_voxel_type(pass.frame.format.type, [&](auto zero) {
    return kernels::distance_to<decltype(zero)>(pass, x, y, opacity);
  });
}

PreviewPixel preview_ray(const Pass& pass, double x, double y) {
  return with_voxel_type(pass.frame.format.type,
                         [&](auto zero) { return kernels::preview_ray<decltype(zero)>(pass, x, y); });
}

}  // namespace gvx::render
