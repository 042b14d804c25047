#include "gvx/surface/draw/placed_brick.h"

#include <algorithm>
#include <cmath>

namespace gvx::surface {

PlacedBrick::Seen seen_of(const FilmPlane& film, const Affine3& to_camera, const std::uint8_t (&low)[3],
                          const std::uint8_t (&high)[3]) {
  const auto corner = [&](int i) {
    return to_camera.point({double((i & 1) != 0 ? high[0] + 1 : low[0]),
                            double((i & 2) != 0 ? high[1] + 1 : low[1]),
                            double((i & 4) != 0 ? high[2] + 1 : low[2])});
  };
  Vec3d corners[8];
  PlacedBrick::Seen seen;
  seen.nearest = INFINITY;
  double farthest = -INFINITY;
  for (int i = 0; i < 8; ++i) {
    corners[i] = corner(i);
    seen.nearest = std::min(seen.nearest, corners[i].z);
    farthest = std::max(farthest, corners[i].z);
  }
  if (!(farthest > 0)) return seen;
  const double widest =
      std::max({length(to_camera.column[0]), length(to_camera.column[1]), length(to_camera.column[2])});
  const bool around_eye = !(seen.nearest > 0);
  const double begins = std::max(seen.nearest, 0.0);
  double cell_depth = 0;
  for (const Vec3d& column : to_camera.column) cell_depth += std::fabs(column.z);
  seen.nearest = std::max(seen.nearest - cell_depth, 0.0);
  seen.cell_pixels = film.orthographic ? widest / film.pixel
                     : around_eye      ? INFINITY
                                       : widest / film.width_at(begins);
  const auto whole = [](double pixel, std::uint32_t most) {
    return static_cast<std::int32_t>(std::clamp(pixel, 0.0, double(most)));
  };
  if (around_eye && !film.orthographic) {
    seen.rect = {0, 0, static_cast<std::int32_t>(film.width), static_cast<std::int32_t>(film.height)};
    return seen;
  }
  double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
  for (const Vec3d& place : corners) {
    const double x = film.x_of(place), y = film.y_of(place);
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  // A thousandth of a pixel for what is rounded.
  constexpr double kMargin = 1e-3;
  seen.rect = {whole(std::ceil(x0 - kMargin), film.width), whole(std::ceil(y0 - kMargin), film.height),
               whole(std::floor(x1 + kMargin) + 1, film.width),
               whole(std::floor(y1 + kMargin) + 1, film.height)};
  return seen;
}

}  // namespace gvx::surface
