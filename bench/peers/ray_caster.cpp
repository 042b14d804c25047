#include "ray_caster.h"

#include <chrono>
#include <fstream>

#include <tbb/parallel_for.h>

#include "gvx/core/ray.h"

namespace gvx::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kTile = 16;  // pixels

}  // namespace

Result<Voxels> read_voxels(const std::string& path, int size) {
  Voxels voxels{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size) * size * size)};
  std::ifstream in(path, std::ios::binary);
  const auto bytes = static_cast<std::streamsize>(voxels.value.size());
  if (!in.read(reinterpret_cast<char*>(voxels.value.data()), bytes)) {
    return Error{path + ": does not hold " + std::to_string(bytes) + " bytes"};
  }
  return voxels;
}

Status RayCaster::look(const PeerView& view) {
  view_ = view;
  table_.resize(kEntries + 1);
  glint_.resize(kEntries + 1);
  for (std::size_t i = 0; i <= kEntries; ++i) {
    const double value = 255.0 * double(i) / kEntries;
    table_[i] = {Vec3f(view.function.color(value)), static_cast<float>(view.function.opacity(value))};
    const float cosine = static_cast<float>(i) / kEntries;
    glint_[i] = view.lighting.specular * std::pow(cosine, view.lighting.shininess);
  }
  double low = 255, high = 0;  // of the values that the function tells apart
  const auto widen = [&](double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  };
  for (const auto& point : view.function.colors) widen(point.value);
  for (const auto& point : view.function.opacities) widen(point.value);
  soft_ = static_cast<float>((high - low) * scene::kSoftGradient);
  pixels_.assign(static_cast<std::size_t>(view.width) * view.height, {});
  prepare();
  return {};
}

Result<double> RayCaster::frame(const scene::Camera& camera) {
  GVX_ASSIGN(const scene::CameraView rays, scene::make_view(camera, view_.width, view_.height));
  const auto start = Clock::now();
  arena_.execute([&] {
    tbb::parallel_for(
        Tile(0, int(view_.height), kTile, 0, int(view_.width), kTile),
        [&](const Tile& tile) { draw(rays, tile); }, tbb::simple_partitioner());
  });
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

std::vector<std::uint8_t> RayCaster::rgb() const {
  std::vector<std::uint8_t> bytes;
  for (const Pixel& pixel : pixels_) {
    for (const float part : {pixel.color.x, pixel.color.y, pixel.color.z}) {
      bytes.push_back(static_cast<std::uint8_t>(std::clamp(part, 0.0f, 1.0f) * 255 + 0.5f));
    }
  }
  return bytes;
}

RayCaster::Way RayCaster::way(const scene::CameraView& rays, int x, int y) const {
  const Ray ray = rays.pixel_ray(x, y);
  const RayInterval inside = intersect(ray, {Vec3d(0), Vec3d(size_ - 1)}, 0, 1e300);
  if (inside.empty()) return {};
  return {Vec3f(ray.at(inside.enter)), Vec3f(ray.direction), static_cast<float>(inside.exit - inside.enter)};
}

}  // namespace gvx::bench
