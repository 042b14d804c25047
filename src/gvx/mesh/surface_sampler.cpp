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
    first = static_cast<int>(cell(floor_of(low - kCellParts / 2 + kCellParts - 1, kCellParts)));
    last = static_cast<int>(cell(floor_of(high - kCellParts / 2, kCellParts)));
    first = std::max(first, 0);
    last = std::min(last, kCells - 1);
  }
};

Vec3f own_normal(const SurfaceTriangle& triangle) {
  // Whole numbers: of a sliver doubles might say that it has no area.
  const Parts a(triangle.corner[0]), b(triangle.corner[1]), c(triangle.corner[2]);
  return Vec3f(normalize(Vec3d(cross(b - a, c - a))));
}

/// A triangle's attributes where its corners have these weights, which add up to `all`.
struct Mixed {
  Vec3f normal, color;

  Mixed(const SurfaceTriangle& triangle, const std::array<std::int64_t, 3>& weight, std::int64_t all) {
    for (int i = 0; i < 3; ++i) {
      const auto share =
          static_cast<float>(static_cast<double>(weight[std::size_t(i)]) / static_cast<double>(all));
      const Normal16& n = triangle.normal[i];
      const Rgb8& c = triangle.color[i];
      normal = normal + share / 32767 * Vec3f(float(n[0]), float(n[1]), float(n[2]));
      color = color + share / 255 * Vec3f(float(c[0]), float(c[1]), float(c[2]));
    }
    // Normals of corners that point against each other say nothing.
    constexpr float kLeast = 1e-3f;
    const float size = length(normal);
    normal = size > kLeast ? normal / size : own_normal(triangle);
  }
  /// At a corner.
  Mixed(const SurfaceTriangle& triangle, int corner)
      : Mixed(triangle, {corner == 0 ? 1 : 0, corner == 1 ? 1 : 0, corner == 2 ? 1 : 0}, 1) {}
};

}  // namespace

std::array<surface::TriangleVertex, 3> SurfaceTriangle::vertices() const {
  std::array<surface::TriangleVertex, 3> vertices;
  for (int i = 0; i < 3; ++i) {
    const Mixed here(*this, i);
    vertices[static_cast<std::size_t>(i)] = {corner[i], surface::pack(here.normal, here.color)};
  }
  return vertices;
}

void SurfaceSampler::add_corners(const SurfaceTriangle& triangle) {
  for (int i = 0; i < 3; ++i) {
    const Parts place(triangle.corner[i]);
    const auto cell = [](std::int64_t part) { return static_cast<int>(floor_of(part, kCellParts)); };
    const Cell at(cell(place.x), cell(place.y), cell(place.z));
    const auto inside = [](int c) { return c >= 0 && c < kCells; };
    if (!inside(at.x) || !inside(at.y) || !inside(at.z)) continue;
    const Mixed here(triangle, i);
    samples_.add(at, here.normal, here.color);
  }
}

void SurfaceSampler::add(const SurfaceTriangle& triangle) {
  for (const auto& corner : triangle.corner) {
    for (int axis = 0; axis < 3; ++axis) GVX_CHECK(std::abs(std::int64_t{corner[axis]}) <= kFarthestParts);
  }
  for (int axis = 0; axis < 3; ++axis) add_along(axis, triangle);
}

/// Cuts the lines along one axis.
void SurfaceSampler::add_along(int axis, const SurfaceTriangle& triangle) {
  const GridAxes axes(axis);
  Parts corner[3];
  for (int i = 0; i < 3; ++i) corner[i] = axes.to_grid(Parts(triangle.corner[i]));
  const auto& [a, b, c] = corner;
  const std::int64_t area = area_of(a, b, c);
  if (area == 0) return;  // seen from its edge: lines along another axis find it
  const std::int64_t side = area < 0 ? -1 : 1;
  const Centres columns(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}));
  const Centres rows(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}));
  for (int v = rows.first; v <= rows.last; ++v) {
    for (int u = columns.first; u <= columns.last; ++u) {
      const Parts line(u * kCellParts + kCellParts / 2, v * kCellParts + kCellParts / 2, 0);
      const std::array<std::int64_t, 3> weight = {side * area_of(line, b, c), side * area_of(line, c, a),
                                                  side * area_of(line, a, b)};
      if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) continue;
      const Wide depth = Wide(weight[0]) * a.z + Wide(weight[1]) * b.z + Wide(weight[2]) * c.z;
      const std::int64_t w = floor_of(depth, Wide(side * area) * kCellParts);
      if (w < 0 || w >= kCells) continue;
      const Mixed here(triangle, weight, side * area);
      samples_.add(axes.from_grid(Cell(u, v, static_cast<int>(w))), here.normal, here.color);
    }
  }
}

}  // namespace gvx::mesh
