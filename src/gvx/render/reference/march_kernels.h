/// \file
/// The kernels of march_pass.h, as templates over the voxel type; each march_*.cpp instantiates one type.
/// Private to this room, and for device sources only.
#pragma once

#include <memory>
#include <optional>

#include "gvx/exec/for_each.h"
#include "gvx/render/march_pass.h"
#include "gvx/render/reference/march.h"
#include "gvx/render/reference/march_view.h"
#include "gvx/render/reference/object_march.h"
#include "gvx/render/reference/step_cursor.h"

namespace gvx::render::kernels {

template <typename Voxel, int N, int M>
struct MarchExact {
  PassView<Voxel, N, M> view;
  FilmView film;
  exec::TileGrid grid;
  exec::BufferView<RayState> rays;
  exec::BufferView<std::uint32_t> unfinished;
  std::uint32_t epoch;
  std::uint64_t lone_ray;

  GVX_HD void operator()(std::uint32_t x, std::uint32_t y) const {
    const std::size_t index = film.index(x, y);
    RayState& ray = rays[index];
    if (ray.epoch != epoch) {
      ray = RayState{};
      ray.epoch = epoch;
    }
    if (ray.phase == RayPhase::finished) return;
    if (lone_ray == Pass::kAllRays || lone_ray == index) {
      RayMarcher<Voxel, N, M>(view, film.ray(x, y)).march_exact(ray);
    }
    if (ray.phase != RayPhase::finished) exec::store_relaxed(&unfinished[grid.tile_of(x, y)], 1);
  }
};

template <typename Voxel, int N, int M>
struct MarchPreview {
  PassView<Voxel, N, M> view;
  FilmView film;
  std::uint32_t block;
  std::uint32_t generation;
  exec::BufferView<const RayState> rays;
  exec::BufferView<PreviewPixel> pixels;
  std::uint32_t epoch;

  GVX_HD void operator()(std::uint32_t block_x, std::uint32_t block_y) const {
    const std::uint32_t x = block_x * block, y = block_y * block;
    const std::size_t pixel = film.index(x, y);
    if (rays[pixel].epoch == epoch && rays[pixel].phase == RayPhase::finished) return;
    if (pixels[pixel].epoch == epoch && pixels[pixel].generation == generation) return;
    RayState state;
    PreviewPixel drawn;
    RayMarcher<Voxel, N, M>(view, film.ray(x, y)).march_preview(state, drawn);
    drawn.color = state.color;
    drawn.opacity = state.opacity;
    pixels[pixel] = drawn;
    pixels[pixel].epoch = epoch;
    pixels[pixel].generation = generation;
  }
};

/// exec::for_each_pixel, where there are kernels for this N and M (GVX_CUDA_SHAPES); check_kernels() sees to
/// it that no other comes to a GPU.
template <int N, int M, typename Functor>
bool for_each_ray(const exec::Device& device, const char* name, const TilesMarch& march, Functor functor) {
  if constexpr (has_kernels(N, M)) {
    return exec::for_each_pixel(device, name, march.grid, march.tiles, march.deadline, functor);
  } else {
    return exec::for_each_pixel_on_cpu(device, march.grid, march.tiles, march.deadline, functor);
  }
}

template <typename Voxel>
bool march_exact(const exec::Device& device, const ExactMarch& march) {
  const Pass& pass = march.pass;
  return with_view<Voxel>(pass.object(), pass.number, [&]<int N, int M>(const PassView<Voxel, N, M>& view) {
    return for_each_ray<N, M>(device, "march_exact", march,
                              MarchExact<Voxel, N, M>{view, pass.film, march.grid, march.rays,
                                                      march.unfinished, pass.epoch, pass.lone_ray});
  });
}

template <typename Voxel>
bool march_preview(const exec::Device& device, const PreviewMarch& march) {
  return with_view<Voxel>(
      march.pass.object(), march.pass.number, [&]<int N, int M>(const PassView<Voxel, N, M>& view) {
        return for_each_ray<N, M>(
            device, "march_preview", march,
            MarchPreview<Voxel, N, M>{view, march.pass.film, march.block, march.generation, march.rays,
                                      march.pixels, march.pass.epoch});
      });
}

/// One ray at a time, on a CPU.
template <typename Voxel, int N, int M>
class MarchOfObject final : public ObjectMarch {
 public:
  explicit MarchOfObject(const PassView<Voxel, N, M>& view) : view_(view) {}

  void begin(const BundleRay& ray) override { ray_.emplace(view_, ray); }
  bool projects() const override { return render::projects(view_.frame); }
  void march_exact(RayState& state) const override { ray_->march_exact(state); }
  void march_projection(RayState& state, double& found, PreviewPixel* preview) const override {
    ray_->march_projection(state, found, preview);
  }
  void march_preview(RayState& state, PreviewPixel& pixel) const override {
    ray_->march_preview(state, pixel);
  }
  double march_to(float opacity, RayState& state) const override { return ray_->march_to(opacity, state); }
  bool look(double t, float gain, PreviewPixel* preview, ObjectStep& shown) override {
    return ray_->look(t, gain, preview, shown);
  }

 private:
  PassView<Voxel, N, M> view_;
  std::optional<StepCursor<Voxel, N, M>> ray_;
};

template <typename Voxel>
std::unique_ptr<ObjectMarch> march_of(const ObjectView& object, std::uint32_t pass) {
  return with_view<Voxel>(
      object, pass, [&]<int N, int M>(const PassView<Voxel, N, M>& view) -> std::unique_ptr<ObjectMarch> {
        return std::make_unique<MarchOfObject<Voxel, N, M>>(view);
      });
}

#define GVX_INSTANTIATE_MARCH(PREFIX, VOXEL)                                                      \
  PREFIX template std::unique_ptr<ObjectMarch> march_of<VOXEL>(const ObjectView&, std::uint32_t); \
  PREFIX template bool march_exact<VOXEL>(const exec::Device&, const ExactMarch&);                \
  PREFIX template bool march_preview<VOXEL>(const exec::Device&, const PreviewMarch&);

}  // namespace gvx::render::kernels
