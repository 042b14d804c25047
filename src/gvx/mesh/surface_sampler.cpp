#include "gvx/mesh/surface_sampler.h"

#include <algorithm>
#include <cmath>

#include "gvx/core/result.h"

namespace gvx::mesh {
namespace {

using surface::Cell;
using surface::GridAxes;
using surface::kCells;
using Parts = Vec3<std::int64_t>;
using Wide = __int128;

constexpr std::int64_t kParts = SurfaceSampler::kParts;

/// Twice the signed area of a triangle in the plane of x and y.
std::int64_t area_of(Parts a, Parts b, Parts c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

std::int64_t floor_of(Wide value, Wide by) {
  const Wide whole = value / by;
  return static_cast<std::int64_t>(whole * by > value ? whole - 1 : whole);
}

/// The cells along an axis whose centres lie between two places.
struct Centres {
  int first, last;

  Centres(std::int64_t low, std::int64_t high) {
    const auto cell = [](std::int64_t place) { return std::clamp<std::int64_t>(place, -1, kCells); };
    first = static_cast<int>(cell(floor_of(low - kParts / 2 + kParts - 1, kParts)));
    last = static_cast<int>(cell(floor_of(high - kParts / 2, kParts)));
    first = std::max(first, 0);
    last = std::min(last, kCells - 1);
  }
};

}  // namespace

void SurfaceSampler::add(const SurfaceTriangle& triangle) {
  Parts corner[3];
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double place = triangle.corner[i][axis];
      GVX_CHECK(std::fabs(place) <= kFarthest);
      corner[i][axis] = std::llround(place * static_cast<double>(kParts));
    }
  }
  for (int axis = 0; axis < 3; ++axis) add_along(axis, triangle, corner);
}

/// Cuts the lines along one axis.
void SurfaceSampler::add_along(int axis, const SurfaceTriangle& triangle, const Parts (&corner)[3]) {
  const GridAxes axes(axis);
  const Parts a = axes.to_grid(corner[0]), b = axes.to_grid(corner[1]), c = axes.to_grid(corner[2]);
  const std::int64_t area = area_of(a, b, c);
  if (area == 0) return;  // seen from its edge: lines along another axis find it
  const std::int64_t side = area < 0 ? -1 : 1;
  const Centres columns(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}));
  const Centres rows(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}));
  for (int v = rows.first; v <= rows.last; ++v) {
    for (int u = columns.first; u <= columns.last; ++u) {
      const Parts line(u * kParts + kParts / 2, v * kParts + kParts / 2, 0);
      const std::int64_t weight[3] = {side * area_of(line, b, c), side * area_of(line, c, a),
                                      side * area_of(line, a, b)};
      if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) continue;
      const Wide depth = Wide(weight[0]) * a.z + Wide(weight[1]) * b.z + Wide(weight[2]) * c.z;
      const std::int64_t w = floor_of(depth, Wide(side * area) * kParts);
      if (w < 0 || w >= kCells) continue;
      Vec3f normal, color;
      for (int i = 0; i < 3; ++i) {
        const auto share =
            static_cast<float>(static_cast<double>(weight[i]) / static_cast<double>(side * area));
        normal = normal + share * triangle.normal[i];
        color = color + share * triangle.color[i];
      }
      const float size = length(normal);
      // Normals of corners that point against each other say nothing: then it is the triangle's own.
      constexpr float kLeast = 1e-3f;
      const Vec3d plane =
          cross(triangle.corner[1] - triangle.corner[0], triangle.corner[2] - triangle.corner[0]);
      const Vec3f unit = size > kLeast ? normal / size : Vec3f(normalize(plane));
      samples_.add(axes.from_grid(Cell(u, v, static_cast<int>(w))), unit, color);
    }
  }
}

}  // namespace gvx::mesh
