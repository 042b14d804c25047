#include "brute_force.h"

#include <algorithm>
#include <cmath>

#include "gvx/exec/parallel.h"

namespace gvx::bench {
namespace {

constexpr int kEntries = 65536;
constexpr float kLeft = 2e-4f;  // to see, where a ray ends
// Matter of opacity 1; a step through it leaves 1/55.
constexpr double kMostExtinction = 32;

}  // namespace

BruteForce::BruteForce(const DenseVolume& volume, const scene::TransferFunction& function)
    : volume_(volume),
      world_to_voxel_(inverse(volume.voxel_to_world())),
      step_(volume.spacing() / kStepsPerVoxel) {
  const double first = std::min(function.colors.front().value, function.opacities.front().value);
  const double last = std::max(function.colors.back().value, function.opacities.back().value);
  first_ = static_cast<float>(first);
  to_entry_ = static_cast<float>((kEntries - 1) / (last - first));
  soft_gradient_ = static_cast<float>((last - first) * scene::kSoftGradient);
  const double unit = function.unit_distance > 0 ? function.unit_distance : volume.spacing();
  for (int i = 0; i < kEntries; ++i) {
    const double value = first + (last - first) * i / (kEntries - 1);
    const double extinction = std::min(-std::log1p(-function.opacity(value)), kMostExtinction);
    table_.push_back(
        {Vec3f(function.color(value)), static_cast<float>(-std::expm1(-extinction * step_ / unit))});
  }
  const Vec3i blocks = volume.blocks();
  for (std::size_t i = 0; i < static_cast<std::size_t>(blocks.x * blocks.y * blocks.z); ++i) {
    const ValueRange range = volume.block_range(i);
    visible_.push_back(function.transparent(double(range.minimum), double(range.maximum)) ? 0 : 1);
  }
}

const BruteForce::Entry& BruteForce::entry(float value) const {
  const float at = std::clamp((value - first_) * to_entry_ + 0.5f, 0.0f, float(kEntries - 1));
  return table_[static_cast<std::size_t>(at)];
}

template <typename Visit>
void BruteForce::walk(const Ray& world, const Visit& visit) const {
  constexpr double kBlock = DenseVolume::kBlock;
  const Ray ray{world_to_voxel_.point(world.origin), world_to_voxel_.vector(world.direction)};
  const RayInterval inside = intersect(ray, volume_.extent(), 0, 1e300);
  if (inside.empty()) return;
  const Vec3i last = volume_.blocks() - Vec3i(1);
  const auto steps = static_cast<std::int64_t>((inside.exit - inside.enter) / step_ + 0.5);
  for (std::int64_t i = 0; i < steps;) {
    const double t = inside.enter + (static_cast<double>(i) + 0.5) * step_;
    const Vec3d p = ray.at(t);
    Vec3i block;
    for (int axis = 0; axis < 3; ++axis) {
      block[axis] = std::clamp<std::int64_t>(static_cast<std::int64_t>(p[axis] / kBlock), 0, last[axis]);
    }
    double t_exit = inside.exit;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray.direction[axis];
      if (d == 0) continue;
      const double face = static_cast<double>(block[axis] + (d > 0 ? 1 : 0)) * kBlock;
      t_exit = std::min(t_exit, (face - ray.origin[axis]) / d);
    }
    const auto end =
        std::max(i + 1, i + static_cast<std::int64_t>(std::ceil(std::max(0.0, t_exit - t) / step_)));
    if (visible_[volume_.block_index(block)] == 0) {
      i = end;
      continue;
    }
    for (; i < std::min(end, steps); ++i) {
      const double here = inside.enter + (static_cast<double>(i) + 0.5) * step_;
      const DenseVolume::Place place = volume_.place(ray.at(here));
      const Entry& e = entry(volume_.value(place));
      if (e.opacity > 0 && !visit(here, place, e)) return;
    }
  }
}

Vec3f BruteForce::ray_color(const Ray& world, const scene::LightingView& lighting, Vec3f background) const {
  const Vec3f to_eye = Vec3f(-world.direction);
  Vec3f color;
  float left = 1;
  walk(world, [&](double t, const DenseVolume::Place& place, const Entry& e) {
    Vec3f sample = e.color;
    if (lighting.lighting.enabled) {
      const Vec3f g = volume_.gradient(place);
      const float steep = length(g);
      const scene::Shade<float> shade =
          lighting.shade<float>(Vec3f(world_to_voxel_.transposed_vector(Vec3d(g))),
                                scene::surface_certainty(steep, soft_gradient_), to_eye, Vec3f(world.at(t)));
      sample = sample * shade.body + shade.glint;
    }
    color = color + left * e.opacity * sample;
    left *= 1 - e.opacity;
    return left > kLeft;
  });
  return color + left * background;
}

Reference BruteForce::render(const render::View& view, std::uint32_t rays_per_axis) const {
  const scene::CameraView camera =
      scene::make_view(view.camera, view.width * rays_per_axis, view.height * rays_per_axis).value();
  const scene::LightingView lighting =
      scene::place_lights(view.lighting, camera.forward, camera.right, camera.up);
  const render::Picture empty{view.width, view.height,
                              std::vector<float>(std::size_t(view.width) * view.height * 4, 1.0f)};
  Reference result{empty, {empty, empty}};
  exec::parallel_for(exec::Device::cpu(), view.height, [&](std::size_t y) {
    for (std::size_t x = 0; x < view.width; ++x) {
      Vec3f sum[2];
      for (std::uint32_t j = 0; j < rays_per_axis; ++j) {
        for (std::uint32_t i = 0; i < rays_per_axis; ++i) {
          const Ray world = camera.pixel_ray(double(x * rays_per_axis + i), double(y * rays_per_axis + j));
          Vec3f& half = sum[(i + j) % 2];
          half = half + ray_color(world, lighting, view.background);
        }
      }
      const float rays = static_cast<float>(rays_per_axis * rays_per_axis);
      const std::size_t out = 4 * (y * view.width + x);
      for (int c = 0; c < 3; ++c) {
        const std::size_t at = out + static_cast<std::size_t>(c);
        result.picture.rgba[at] = (sum[0][c] + sum[1][c]) / rays;
        result.half[0].rgba[at] = sum[0][c] * 2 / rays;
        result.half[1].rgba[at] = sum[1][c] * 2 / rays;
      }
    }
  });
  return result;
}

std::optional<double> BruteForce::depth(const Ray& world, double opacity) const {
  std::optional<double> found;
  float left = 1;
  walk(world, [&](double t, const DenseVolume::Place&, const Entry& e) {
    left *= 1 - e.opacity;
    if (1 - left >= static_cast<float>(opacity)) found = t;
    return !found.has_value();
  });
  return found;
}

}  // namespace gvx::bench
