/// \file
/// The kernels of march_pass.h, as templates over the voxel type; each march_*.cpp instantiates one type.
/// Private to this room, and for device sources only.
#pragma once

#include "gvx/exec/for_each.h"
#include "gvx/render/march_pass.h"
#include "gvx/render/reference/march.h"
#include "gvx/render/reference/march_view.h"

namespace gvx::render::kernels {

template <typename Voxel, int N, int M>
struct MarchExact {
  PassView<Voxel, N, M> view;
  exec::TileGrid grid;
  exec::BufferView<RayState> rays;
  exec::BufferView<std::uint32_t> unfinished;
  std::uint32_t epoch;
  std::uint64_t lone_ray;

  GVX_HD void operator()(std::uint32_t x, std::uint32_t y) const {
    const std::size_t index = std::size_t(y) * view.frame.width + x;
    RayState& ray = rays[index];
    if (ray.epoch != epoch) {
      ray = RayState{};
      ray.epoch = epoch;
    }
    if (ray.phase == RayPhase::finished) return;
    if (lone_ray == Pass::kAllRays || lone_ray == index) RayMarcher<Voxel, N, M>(view, x, y).march_exact(ray);
    if (ray.phase != RayPhase::finished) exec::store_relaxed(&unfinished[grid.tile_of(x, y)], 1);
  }
};

template <typename Voxel, int N, int M>
struct MarchPreview {
  PassView<Voxel, N, M> view;
  std::uint32_t block;
  std::uint32_t generation;
  exec::BufferView<const RayState> rays;
  exec::BufferView<PreviewPixel> pixels;
  std::uint32_t epoch;

  GVX_HD void operator()(std::uint32_t block_x, std::uint32_t block_y) const {
    const std::uint32_t x = block_x * block, y = block_y * block;
    const std::size_t pixel = std::size_t(y) * view.frame.width + x;
    if (rays[pixel].epoch == epoch && rays[pixel].phase == RayPhase::finished) return;
    if (pixels[pixel].epoch == epoch && pixels[pixel].generation == generation) return;
    pixels[pixel] = RayMarcher<Voxel, N, M>(view, x, y).march_preview();
    pixels[pixel].epoch = epoch;
    pixels[pixel].generation = generation;
  }
};

/// exec::for_each_pixel, where there are kernels for this N and M (GVX_CUDA_SHAPES); check_kernels() sees to
/// it that no other comes to a GPU.
template <int N, int M, typename Functor>
bool for_each_ray(const exec::Device& device, const char* name, exec::TileGrid grid,
                  exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline, Functor functor) {
  if constexpr (has_kernels(N, M)) {
    return exec::for_each_pixel(device, name, grid, tiles, deadline, functor);
  } else {
    return exec::for_each_pixel_on_cpu(device, grid, tiles, deadline, functor);
  }
}

template <typename Voxel>
bool march_exact(const exec::Device& device, const Pass& pass, exec::TileGrid grid,
                 exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline,
                 exec::BufferView<RayState> rays, exec::BufferView<std::uint32_t> unfinished) {
  return with_view<Voxel>(pass, [&]<int N, int M>(const PassView<Voxel, N, M>& view) {
    return for_each_ray<N, M>(
        device, "march_exact", grid, tiles, deadline,
        MarchExact<Voxel, N, M>{view, grid, rays, unfinished, pass.epoch, pass.lone_ray});
  });
}

template <typename Voxel>
bool march_preview(const exec::Device& device, const Pass& pass, exec::TileGrid grid,
                   exec::BufferView<const std::uint32_t> tiles, exec::Deadline deadline, std::uint32_t block,
                   std::uint32_t generation, exec::BufferView<const RayState> rays,
                   exec::BufferView<PreviewPixel> pixels) {
  return with_view<Voxel>(pass, [&]<int N, int M>(const PassView<Voxel, N, M>& view) {
    return for_each_ray<N, M>(device, "march_preview", grid, tiles, deadline,
                              MarchPreview<Voxel, N, M>{view, block, generation, rays, pixels, pass.epoch});
  });
}

/// One ray alone, on a CPU.
template <typename Voxel>
void march_ray(const Pass& pass, double x, double y, RayState& state) {
  with_view<Voxel>(pass, [&]<int N, int M>(const PassView<Voxel, N, M>& view) {
    RayMarcher<Voxel, N, M>(view, x, y).march_exact(state);
  });
}

template <typename Voxel>
PreviewPixel preview_ray(const Pass& pass, double x, double y) {
  return with_view<Voxel>(pass, [&]<int N, int M>(const PassView<Voxel, N, M>& view) {
    return RayMarcher<Voxel, N, M>(view, x, y).march_preview();
  });
}

template <typename Voxel>
double distance_to(const Pass& pass, double x, double y, float opacity) {
  return with_view<Voxel>(pass, [&]<int N, int M>(const PassView<Voxel, N, M>& view) {
    return RayMarcher<Voxel, N, M>(view, x, y).march_to(opacity);
  });
}

#define GVX_INSTANTIATE_MARCH(PREFIX, VOXEL)                                                                \
  PREFIX template void march_ray<VOXEL>(const Pass&, double, double, RayState&);                            \
  PREFIX template PreviewPixel preview_ray<VOXEL>(const Pass&, double, double);                             \
  PREFIX template double distance_to<VOXEL>(const Pass&, double, double, float);                            \
  PREFIX template bool march_exact<VOXEL>(const exec::Device&, const Pass&, exec::TileGrid,                 \
                                          exec::BufferView<const std::uint32_t>, exec::Deadline,            \
                                          exec::BufferView<RayState>, exec::BufferView<std::uint32_t>);     \
  PREFIX template bool march_preview<VOXEL>(const exec::Device&, const Pass&, exec::TileGrid,               \
                                            exec::BufferView<const std::uint32_t>, exec::Deadline,          \
                                            std::uint32_t, std::uint32_t, exec::BufferView<const RayState>, \
                                            exec::BufferView<PreviewPixel>);

}  // namespace gvx::render::kernels
