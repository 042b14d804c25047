#include "gvx/render/march_pass.h"

#include <string>

#include "gvx/render/reference/march_kernels.h"
#include "gvx/render/reference/object_march.h"
#include "gvx/render/reference/scene_ray.h"
#include "gvx/render/tile/scene_march.h"
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

Status check_objects(const exec::Device& device, std::size_t objects, std::size_t projecting) {
  if (objects > 1 && projecting > kMostProjecting) {
    return Error{"objects: at most " + std::to_string(kMostProjecting) +
                 " may show a greatest, least or mean value, not " + std::to_string(projecting)};
  }
  if (device.kind() == exec::DeviceKind::cpu || objects <= 1) return {};
  return Error{"a GPU renders scenes of one object so far, not of " + std::to_string(objects) +
               "; use --device cpu"};
}

bool march_exact(const exec::Device& device, const ExactMarch& march) {
  if (!march.pass.of_one_object()) return scene_march(device, march);
  if (device.kind() == exec::DeviceKind::cpu && marches_tiles(march.pass)) return tile_march(device, march);
  return with_voxel_type(march.pass.object().frame.format.type,
                         [&](auto zero) { return kernels::march_exact<decltype(zero)>(device, march); });
}

bool march_preview(const exec::Device& device, const PreviewMarch& march) {
  if (!march.pass.of_one_object()) return scene_preview(device, march);
  if (device.kind() == exec::DeviceKind::cpu && marches_tiles(march.pass)) return tile_preview(device, march);
  return with_voxel_type(march.pass.object().frame.format.type,
                         [&](auto zero) { return kernels::march_preview<decltype(zero)>(device, march); });
}

void march_ray(const Pass& pass, const ObjectView& object, const BundleRay& ray, RayState& state) {
  const auto march = march_of(object, pass.number);
  march->begin(ray);
  march->march_exact(state);
}

void march_ray(const Pass& pass, double x, double y, RayState& state) {
  march_ray(pass, pass.object(), pass.film.ray(x, y), state);
}

PreviewPixel preview_ray(const Pass& pass, double x, double y) {
  if (!pass.of_one_object()) return SceneRay(pass, x, y).preview();
  const auto march = march_of(pass.object(), pass.number);
  march->begin(pass.film.ray(x, y));
  RayState state;
  PreviewPixel pixel;
  march->march_preview(state, pixel);
  pixel.color = state.color;
  pixel.opacity = state.opacity;
  return pixel;
}

RayReach reach(const Pass& pass, double x, double y, float opacity) {
  if (!pass.of_one_object() || projects(pass.object().frame)) return SceneRay(pass, x, y).reach(opacity);
  const auto march = march_of(pass.object(), pass.number);
  march->begin(pass.film.ray(x, y));
  RayState state;
  RayReach reach{opacity};
  reach.distance = march->march_to(opacity, state);
  if (reach.distance < INFINITY) reach.object = 0;
  return reach;
}

std::unique_ptr<ObjectMarch> march_of(const ObjectView& object, std::uint32_t pass) {
  return with_voxel_type(object.frame.format.type,
                         [&](auto zero) { return kernels::march_of<decltype(zero)>(object, pass); });
}

}  // namespace gvx::render
