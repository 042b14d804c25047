#include "reference.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "gvx/exec/parallel.h"
#include "gvx/scene/lighting.h"

namespace gvx::tests {

double ReferenceVolume::interpolate(
    Vec3d p, const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& read) const {
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
    if (w > 0) sum += w * read(cx ? high[0] : low[0], cy ? high[1] : low[1], cz ? high[2] : low[2]);
  }
  return sum;
}

double ReferenceVolume::value(std::size_t plane, Vec3d p) const {
  return interpolate(p, [&](auto x, auto y, auto z) { return voxel_of(plane, x, y, z); });
}

namespace {

/// The centred cubic B-spline, and its slope.
double spline(double x) {
  const double u = std::abs(x);
  return u < 1 ? 2.0 / 3 - u * u + u * u * u / 2 : u < 2 ? (2 - u) * (2 - u) * (2 - u) / 6 : 0;
}
double spline_slope(double x) {
  const double u = std::abs(x), slope = u < 1 ? 1.5 * u * u - 2 * u : u < 2 ? -(2 - u) * (2 - u) / 2 : 0;
  return x < 0 ? -slope : slope;
}

/// The gradient of the sum of such splines around the voxels' centres, times what voxel(x, y, z) says.
template <typename Voxel>
Vec3d spline_gradient(Vec3d p, Vec3i dimensions, const Voxel& voxel) {
  Vec3i first;
  for (int axis = 0; axis < 3; ++axis) first[axis] = static_cast<std::int64_t>(std::floor(p[axis] - 0.5)) - 1;
  Vec3d g;
  for (int i = 0; i < 64; ++i) {
    const Vec3i at = first + Vec3i(i % 4, i / 4 % 4, i / 16);
    Vec3d value, slope;
    for (int axis = 0; axis < 3; ++axis) {
      const double from_centre = p[axis] - (static_cast<double>(at[axis]) + 0.5);
      value[axis] = spline(from_centre);
      slope[axis] = spline_slope(from_centre);
    }
    const auto held = [&](int axis) { return std::clamp<std::int64_t>(at[axis], 0, dimensions[axis] - 1); };
    const double v = voxel(held(0), held(1), held(2));
    g = g + v * Vec3d(slope.x * value.y * value.z, value.x * slope.y * value.z, value.x * value.y * slope.z);
  }
  return g;
}

/// The values of a plane.
scene::ValueSpan values_of(const ReferenceVolume& volume, std::size_t plane) {
  scene::ValueSpan span{volume.voxel_of(plane, 0, 0, 0), volume.voxel_of(plane, 0, 0, 0)};
  for (std::int64_t z = 0; z < volume.dimensions.z; ++z) {
    for (std::int64_t y = 0; y < volume.dimensions.y; ++y) {
      for (std::int64_t x = 0; x < volume.dimensions.x; ++x) {
        const double value = volume.voxel_of(plane, x, y, z);
        span = {std::min(span.minimum, value), std::max(span.maximum, value)};
      }
    }
  }
  return span;
}

/// As the engine derives it from the span of a function's values, of those that there are, in physical units
/// a voxel.
double soft_gradient_of(const scene::TransferFunction& f, scene::ValueSpan values) {
  const double first = std::min(f.colors.front().value, f.opacities.front().value);
  const double last = std::max(f.colors.back().value, f.opacities.back().value);
  return (std::min(last, values.maximum) - std::max(first, values.minimum)) * scene::kSoftGradient;
}

/// What one ray needs.
struct Tracer {
  const ReferenceVolume& volume;
  const render::View& view;
  const std::vector<double>& soft_gradient;  // of each plane
  double step, spacing;
  Affine3 world_to_voxel;
  scene::LightingView lighting;
  Ray world, ray;
  RayInterval inside;

  Vec3d color;
  double left = 1;

  const scene::TransferFunction& function(std::size_t channel) const {
    return view.functions[std::min(channel, view.functions.size() - 1)];
  }
  double unit() const {
    return view.functions[0].unit_distance > 0 ? view.functions[0].unit_distance : spacing;
  }
  scene::Shade<double> shade(Vec3d gradient, double certainty, double t) const {
    return lighting.shade<double>(world_to_voxel.transposed_vector(gradient), certainty, -world.direction,
                                  world.at(t));
  }
  void add(Vec3d c, double opacity) {
    color = color + left * opacity * c;
    left *= 1 - opacity;
  }

  /// Returns whether there is anything.
  bool composite_scalars(Vec3d p, double t) {
    double extinction = 0;
    Vec3d sum;
    for (std::size_t c = 0; c < volume.planes(); ++c) {
      const double value = volume.value(c, p);
      double e = std::min(-std::log1p(-function(c).opacity(value)), 50.0);
      if (e <= 0) continue;
      const Vec3d g = volume.gradient(c, p);
      e *= function(c).gradient_factor(length(world_to_voxel.transposed_vector(g)));
      const double steep = length(g);
      const scene::Shade<double> s = shade(g, scene::surface_certainty(steep, soft_gradient[c]), t);
      sum = sum + e * (function(c).color(value) * s.body + s.glint);
      extinction += e;
    }
    if (extinction <= 0) return false;
    add(sum / extinction, 1 - std::exp(-extinction * step / unit()));
    return true;
  }

  bool composite_label(Vec3d p, double t) {
    const double label = volume.nearest(p), opacity = function(0).opacity(label);
    if (opacity <= 0) return false;
    const Vec3d gradient = volume.region_gradient(label, p);
    // Where the region changes by less than a 64th a voxel nothing else is near.
    constexpr double kSharpness = 64;
    const scene::Shade<double> s = shade(gradient, std::min(kSharpness * length(gradient), 1.0), t);
    add(function(0).color(label) * s.body + s.glint, 1 - std::pow(1 - opacity, step / unit()));
    return true;
  }

  /// Stored colours and opacities are 0 to 255; unlit unless there are normals.
  bool composite_color(Vec3d p, double t) {
    const double opacity = volume.value(3, p) / 255;
    if (opacity <= 0) return false;
    const auto plane = [&](std::size_t i) { return volume.value(i, p); };
    Vec3d c = Vec3d(plane(0), plane(1), plane(2)) / (255 * opacity);
    if (view.lighting.enabled && volume.planes() == 7) {
      const Vec3d normal = Vec3d(plane(4) - 127, plane(5) - 127, plane(6) - 127) / 127.0;
      const scene::Shade<double> s = shade(normal, std::min(1.0, length(normal) / opacity), t);
      c = c * s.body + s.glint;
    }
    add(c, 1 - std::pow(1 - std::min(opacity, 0.9999), step / spacing));
    return true;
  }

  void project() {
    std::vector<double> values(volume.planes());
    std::int64_t count = 0;
    for (double t = inside.enter + 0.5 * step; t < inside.exit; t += step, ++count) {
      for (std::size_t c = 0; c < values.size(); ++c) {
        const double v = volume.value(c, ray.at(t));
        double& all = values[c];
        all = view.mode == scene::Mode::mean      ? all + v
              : count == 0                        ? v
              : view.mode == scene::Mode::maximum ? std::max(all, v)
                                                  : std::min(all, v);
      }
    }
    for (std::size_t c = 0; count > 0 && c < values.size(); ++c) {
      const double value =
          view.mode == scene::Mode::mean ? values[c] / static_cast<double>(count) : values[c];
      color = color + function(c).opacity(value) * function(c).color(value);
      left *= 1 - function(c).opacity(value);
    }
  }

  void find_surface() {
    const auto over = [&](double t) { return volume.value(0, ray.at(t)) - view.isovalue; };
    for (double t = inside.enter; t < inside.exit; t += step) {
      double a = t, b = std::min(t + step, inside.exit);
      if ((over(a) < 0) == (over(b) < 0)) continue;
      for (int i = 0; i < 40; ++i) ((over(a) < 0) == (over((a + b) / 2) < 0) ? a : b) = (a + b) / 2;
      const scene::Shade<double> s = shade(volume.gradient(0, ray.at(a)), 1, a);
      add(function(0).color(view.isovalue) * s.body + s.glint, 1);
      return;
    }
  }

  template <typename Visit>
  void composite(Visit visit_necessary) {
    for (double t = inside.enter + 0.5 * step; t < inside.exit && left > 1e-4; t += step) {
      const Vec3d p = ray.at(t);
      const bool seen = volume.content == VoxelContent::scalar   ? composite_scalars(p, t)
                        : volume.content == VoxelContent::labels ? composite_label(p, t)
                                                                 : composite_color(p, t);
      if (seen) visit_necessary(p);
    }
  }
};

}  // namespace

Vec3d ReferenceVolume::gradient(std::size_t plane, Vec3d p) const {
  return spline_gradient(p, dimensions, [&](auto x, auto y, auto z) { return voxel_of(plane, x, y, z); });
}

Vec3d ReferenceVolume::region_gradient(double label, Vec3d p) const {
  return spline_gradient(p, dimensions,
                         [&](auto x, auto y, auto z) { return voxel(x, y, z) == label ? 1.0 : 0.0; });
}

double ReferenceVolume::nearest(Vec3d p) const {
  const auto at = [&](int axis) {
    return std::clamp(static_cast<std::int64_t>(p[axis]), std::int64_t(0), dimensions[axis] - 1);
  };
  return voxel(at(0), at(1), at(2));
}

ReferencePicture render_reference(const ReferenceVolume& volume, const render::View& view,
                                  double samples_per_voxel, std::int64_t m) {
  const scene::CameraView camera = scene::make_view(view.camera, view.width, view.height).value();
  const Affine3& place = volume.voxel_to_world;
  const double spacing =
      std::min({length(place.column[0]), length(place.column[1]), length(place.column[2])});
  const Vec3d size(volume.dimensions);
  const Box3d box = intersect({view.clip.minimum * size, view.clip.maximum * size}, {{0, 0, 0}, size});

  std::vector<double> soft_gradient;
  for (std::size_t c = 0; c < volume.planes() && volume.content == VoxelContent::scalar; ++c) {
    const scene::TransferFunction& function = view.functions[std::min(c, view.functions.size() - 1)];
    soft_gradient.push_back(soft_gradient_of(function, values_of(volume, c)));
  }
  ReferencePicture result;
  result.picture = {view.width, view.height, std::vector<float>(std::size_t(view.width) * view.height * 4)};
  std::mutex mutex;
  exec::parallel_for(exec::Device::cpu(), view.height, [&](std::size_t row) {
    const auto y = static_cast<std::uint32_t>(row);
    std::set<std::tuple<std::int64_t, std::int64_t, std::int64_t>> necessary;
    for (std::uint32_t x = 0; x < view.width; ++x) {
      Tracer tracer{volume,
                    view,
                    soft_gradient,
                    spacing / samples_per_voxel,
                    spacing,
                    inverse(volume.voxel_to_world),
                    scene::place_lights(view.lighting, camera.forward, camera.right, camera.up),
                    camera.pixel_ray(x, y),
                    {},
                    {},
                    {}};
      tracer.ray = {tracer.world_to_voxel.point(tracer.world.origin),
                    tracer.world_to_voxel.vector(tracer.world.direction)};
      tracer.inside = intersect(tracer.ray, box, 0, 1e300);
      if (!tracer.inside.empty()) {
        if (view.mode == scene::Mode::composite) {
          tracer.composite([&](Vec3d p) {
            necessary.emplace(static_cast<std::int64_t>(p.x) / m, static_cast<std::int64_t>(p.y) / m,
                              static_cast<std::int64_t>(p.z) / m);
          });
        } else if (view.mode == scene::Mode::isosurface) {
          tracer.find_surface();
        } else {
          tracer.project();
        }
      }
      float* out = &result.picture.rgba[4 * (std::size_t(y) * view.width + x)];
      for (int c = 0; c < 3; ++c) {
        out[c] =
            static_cast<float>(std::min(1.0, tracer.color[c]) + tracer.left * double(view.background[c]));
      }
      out[3] = 1;
    }
    const std::lock_guard lock(mutex);
    result.necessary_bricks.merge(necessary);
  });
  return result;
}

}  // namespace gvx::tests
