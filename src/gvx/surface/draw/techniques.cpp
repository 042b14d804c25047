#include "gvx/surface/draw/techniques.h"

#include <algorithm>
#include <cmath>

#include "gvx/surface/cast.h"

namespace gvx::surface {
namespace {

constexpr double kBeyondAll = 1e300;

PixelRect around(double x0, double x1, double y0, double y1, const PixelRect& part) {
  const auto whole = [](double v, std::int32_t low, std::int32_t high) {
    return static_cast<std::int32_t>(std::clamp(v, double(low), double(high)));
  };
  return {whole(std::ceil(x0), part.x0, part.x1), whole(std::ceil(y0), part.y0, part.y1),
          whole(std::floor(x1) + 1, part.x0, part.x1), whole(std::floor(y1) + 1, part.y0, part.y1)};
}

/// The pixels that may see a triangle with something before the eye.
PixelRect pixels_of(const FilmPlane& film, const Vec3d (&corner)[3], const PixelRect& part) {
  double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
  const auto add_x = [&](double x) { x0 = std::min(x0, x), x1 = std::max(x1, x); };
  const auto add_y = [&](double y) { y0 = std::min(y0, y), y1 = std::max(y1, y); };
  for (int i = 0; i < 3; ++i) {
    const Vec3d &a = corner[i], &b = corner[(i + 1) % 3];
    if (film.orthographic || a.z > 0) add_x(film.x_of(a)), add_y(film.y_of(a));
    if (film.orthographic || (a.z > 0) == (b.z > 0)) continue;
    // Where an edge comes to the eye's plane it is seen infinitely far to one side.
    const Vec3d at = a + (a.z / (a.z - b.z)) * (b - a);
    const double rounding = 1e-9 * (std::fabs(at.x) + std::fabs(at.y));
    for (const double sign : {-1.0, 1.0}) {
      if (sign * at.x >= -rounding) add_x(sign * INFINITY);
      if (sign * at.y >= -rounding) add_y(-sign * INFINITY);
    }
  }
  constexpr double kMargin = 1e-6;  // for what is rounded
  return around(x0 - kMargin, x1 + kMargin, y0 - kMargin, y1 + kMargin, part);
}

}  // namespace

void cast_samples(const DrawnSamples& drawn, TileHits& hits) {
  for (std::int32_t y = drawn.part.y0; y < drawn.part.y1; ++y) {
    for (std::int32_t x = drawn.part.x0; x < drawn.part.x1; ++x) {
      const std::size_t pixel = hits.index(x, y);
      const Ray ray = drawn.placed.ray(drawn.film.ray(x, y));
      const CastHit hit = cast(drawn.brick, ray, {0, std::min(double(hits.depth[pixel]), kBeyondAll)});
      if (!hit.hit) continue;
      hits.put(pixel, static_cast<float>(0.5 * (hit.enter + hit.exit)), drawn.number, packed(hit.cell));
    }
  }
}

void splat_samples(const DrawnSamples& drawn, TileHits& hits) {
  const GridAxes axes(drawn.brick.axis);
  const Affine3& to_camera = drawn.placed.to_camera;
  // How far a cell reaches from its middle.
  Vec3d reach;
  for (int axis = 0; axis < 3; ++axis) {
    for (const Vec3d& column : to_camera.column) reach[axis] += 0.5 * std::fabs(column[axis]);
  }
  for (int v = 0; v < kCells; ++v) {
    for (int u = 0; u < kCells; ++u) {
      for (std::uint32_t cells = drawn.brick.grid.column(u, v); cells != 0; cells &= cells - 1) {
        const Cell cell = axes.from_grid(Cell(u, v, lowest_bit(cells)));
        const Vec3d middle = to_camera.point(Vec3d(cell) + Vec3d(0.5));
        if (!(middle.z + reach.z > 0)) continue;
        PixelRect rect = drawn.part;
        if (middle.z - reach.z > 0 || drawn.film.orthographic) {
          const double width = drawn.film.width_at(middle.z - reach.z),
                       far = drawn.film.width_at(middle.z + reach.z);
          const auto least = [&](double low) { return low / (low < 0 ? width : far); };
          const auto most = [&](double high) { return high / (high > 0 ? width : far); };
          const double x = drawn.film.half_width - 0.5, y0 = drawn.film.half_height - 0.5;
          rect = around(x + least(middle.x - reach.x), x + most(middle.x + reach.x),
                        y0 - most(middle.y + reach.y), y0 - least(middle.y - reach.y), drawn.part);
        }
        const Box3d box{Vec3d(cell), Vec3d(cell) + Vec3d(1)};
        for (std::int32_t y = rect.y0; y < rect.y1; ++y) {
          for (std::int32_t x = rect.x0; x < rect.x1; ++x) {
            const RayInterval inside = intersect(drawn.placed.ray(drawn.film.ray(x, y)), box, 0, kBeyondAll);
            if (!(inside.enter <= inside.exit)) continue;
            hits.put(hits.index(x, y), static_cast<float>(0.5 * (inside.enter + inside.exit)), drawn.number,
                     packed(cell));
          }
        }
      }
    }
  }
}

void rasterise(const DrawnTriangles& drawn, TileHits& hits) {
  for (std::uint32_t triangle = 0; triangle < drawn.triangles.triangles; ++triangle) {
    rasterise_one(drawn, triangle, hits);
  }
}

void rasterise_one(const DrawnTriangles& drawn, std::uint32_t triangle, TileHits& hits) {
  const FilmPlane& film = drawn.film;
  const SeenTriangle seen(drawn.placed, drawn.triangles, triangle);
  const auto& corner = seen.corner;
  if (!(std::max({corner[0].z, corner[1].z, corner[2].z}) > 0)) return;  // behind the eye
  const PixelRect rect = pixels_of(film, corner, drawn.part);
  for (std::int32_t py = rect.y0; py < rect.y1; ++py) {
    for (std::int32_t px = rect.x0; px < rect.x1; ++px) {
      Vec3d weight;
      double depth = 0;
      if (!seen.meets(film.ray(px, py), film.orthographic, weight, depth) || depth < drawn.nearest) continue;
      hits.put(hits.index(px, py), static_cast<float>(depth), drawn.number, triangle);
    }
  }
}

}  // namespace gvx::surface
