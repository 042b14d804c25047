#include "reference.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "gvx/exec/parallel.h"

namespace gvx::tests {

double ReferenceVolume::value(Vec3d p) const {
  std::int64_t low[3], high[3];
  double weight[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double last = static_cast<double>(dimensions[axis] - 1);
    const double at = std::clamp(p[axis] - 0.5, 0.0, last);
    low[axis] = static_cast<std::int64_t>(at);
    high[axis] = std::min(low[axis] + 1, dimensions[axis] - 1);
    weight[axis] = at - static_cast<double>(low[axis]);
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const bool cx = (corner & 1) != 0, cy = (corner & 2) != 0, cz = (corner & 4) != 0;
    const double w = (cx ? weight[0] : 1 - weight[0]) * (cy ? weight[1] : 1 - weight[1]) *
                     (cz ? weight[2] : 1 - weight[2]);
    if (w > 0) sum += w * voxel(cx ? high[0] : low[0], cy ? high[1] : low[1], cz ? high[2] : low[2]);
  }
  return sum;
}

Vec3d ReferenceVolume::gradient(Vec3d p) const {
  Vec3d g;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d before = p, after = p;
    before[axis] -= 0.5;
    after[axis] += 0.5;
    g[axis] = value(after) - value(before);
  }
  return g;
}

ReferencePicture render_reference(const ReferenceVolume& volume, const render::View& view,
                                  double samples_per_voxel, double soft_gradient, std::int64_t m) {
  const scene::CameraView camera = scene::make_view(view.camera, view.width, view.height).value();
  const Affine3 world_to_voxel = inverse(volume.voxel_to_world);
  const Affine3& place = volume.voxel_to_world;
  const double spacing =
      std::min({length(place.column[0]), length(place.column[1]), length(place.column[2])});
  const double step = spacing / samples_per_voxel;
  const double unit = view.functions[0].unit_distance > 0 ? view.functions[0].unit_distance : spacing;
  const Vec3d size(volume.dimensions);
  const Box3d box = intersect({view.clip.minimum * size, view.clip.maximum * size}, {{0, 0, 0}, size});
  const scene::LightingView lighting =
      scene::place_lights(view.lighting, camera.forward, camera.right, camera.up);

  ReferencePicture result;
  result.picture = {view.width, view.height, std::vector<float>(std::size_t(view.width) * view.height * 4)};
  std::mutex mutex;
  exec::parallel_for(exec::Device::cpu(), view.height, [&](std::size_t row) {
    const auto y = static_cast<std::uint32_t>(row);
    std::set<std::tuple<std::int64_t, std::int64_t, std::int64_t>> necessary;
    for (std::uint32_t x = 0; x < view.width; ++x) {
      const Ray world = camera.pixel_ray(x, y);
      const Ray ray{world_to_voxel.point(world.origin), world_to_voxel.vector(world.direction)};
      const RayInterval inside = intersect(ray, box, 0, 1e300);
      Vec3d color;
      double left = 1;
      for (double t = inside.enter + 0.5 * step; !inside.empty() && t < inside.exit && left > 1e-4;
           t += step) {
        const Vec3d p = ray.at(t);
        const double value = volume.value(p);
        const double opacity = view.functions[0].opacity(value);
        if (opacity <= 0) continue;
        necessary.emplace(static_cast<std::int64_t>(p.x) / m, static_cast<std::int64_t>(p.y) / m,
                          static_cast<std::int64_t>(p.z) / m);
        const double step_opacity = 1 - std::pow(1 - opacity, step / unit);
        Vec3d sample = view.functions[0].color(value);
        if (view.lighting.enabled) {
          const Vec3d g = volume.gradient(p);
          const double steep = length(g);
          const scene::Shade<double> shade =
              lighting.shade<double>(world_to_voxel.transposed_vector(g), steep / (steep + soft_gradient),
                                     -world.direction, world.at(t));
          sample = sample * shade.body + shade.glint;
        }
        color = color + left * step_opacity * sample;
        left *= 1 - step_opacity;
      }
      float* out = &result.picture.rgba[4 * (std::size_t(y) * view.width + x)];
      for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(color[c] + left * double(view.background[c]));
      out[3] = 1;
    }
    const std::lock_guard lock(mutex);
    result.necessary_bricks.merge(necessary);
  });
  return result;
}

double psnr(const render::Picture& a, const render::Picture& b) {
  GVX_CHECK(a.width == b.width && a.height == b.height);
  double sum = 0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double d = std::clamp(double(a.rgba[i]), 0.0, 1.0) - std::clamp(double(b.rgba[i]), 0.0, 1.0);
    sum += d * d;
  }
  const double mean = sum / (static_cast<double>(a.rgba.size()) * 3 / 4);
  return mean > 0 ? -10 * std::log10(mean) : std::numeric_limits<double>::infinity();
}

}  // namespace gvx::tests
