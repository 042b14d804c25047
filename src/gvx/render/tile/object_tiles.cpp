#include "gvx/render/tile/object_tiles.h"

#include <algorithm>
#include <cmath>

#include "gvx/core/affine.h"
#include "gvx/core/box_parts.h"

namespace gvx::render {
namespace {

/// Whole rays between two places, and one more on either side for rounding.
void put_span(double from, double to, std::uint32_t count, std::int32_t& first, std::int32_t& last) {
  const double end = count;
  first = static_cast<std::int32_t>(std::clamp(std::floor(from) - 1, 0.0, end));
  last = static_cast<std::int32_t>(std::clamp(std::ceil(to) + 1, -1.0, end - 1));
}

}  // namespace

FilmRect film_rect_of(const FilmView& film, const FrameView& object) {
  const scene::CameraView& camera = film.camera;
  const Affine3 tree_to_world = inverse(object.world_to_tree);
  const FilmRect all{0, static_cast<std::int32_t>(film.width) - 1, 0,
                     static_cast<std::int32_t>(film.height) - 1};
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, nearest = INFINITY,
         farthest = -INFINITY, reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = box_corner(object.bundle.box, corner);
    const Vec3d from_eye = tree_to_world.vector(p);
    const double ahead = dot(from_eye, camera.forward), scale = camera.orthographic ? 1 : ahead;
    const double at[2] = {camera.half_width - 0.5 + dot(from_eye, camera.right) / (scale * camera.pixel),
                          camera.half_height - 0.5 - dot(from_eye, camera.up) / (scale * camera.pixel)};
    for (int k = 0; k < 2; ++k) low[k] = std::min(low[k], at[k]), high[k] = std::max(high[k], at[k]);
    nearest = std::min(nearest, ahead);
    farthest = std::max(farthest, ahead);
    reach = std::max(reach, length(from_eye));
  }
  if (object.bundle.box.empty() || farthest < 0) return {};
  // Beside the eye projections are of no use.
  constexpr double kBeside = 1e-6;
  const bool sound = camera.orthographic || nearest > kBeside * reach;
  if (!sound || !std::isfinite(low[0] + high[0] + low[1] + high[1])) return all;
  FilmRect rect;
  put_span(low[0], high[0], film.width, rect.x0, rect.x1);
  put_span(low[1], high[1], film.height, rect.y0, rect.y1);
  return rect;
}

template <typename Function>
void ObjectTiles::for_tiles(const FilmRect& rect, Function function) const {
  if (rect.empty()) return;
  const auto tile = [&](std::int32_t pixel) { return static_cast<std::uint32_t>(pixel) / grid_.tile; };
  for (std::uint32_t y = tile(rect.y0); y <= tile(rect.y1); ++y) {
    for (std::uint32_t x = tile(rect.x0); x <= tile(rect.x1); ++x) function(y * grid_.tiles_x() + x);
  }
}

ObjectTiles::ObjectTiles(const FilmView& film, std::span<const ObjectView> objects)
    : grid_{film.width, film.height} {
  first_.resize(grid_.tiles() + 1);
  for (const ObjectView& object : objects) {
    rects_.push_back(film_rect_of(film, object.frame));
    for_tiles(rects_.back(), [&](std::uint32_t tile) { ++first_[tile + 1]; });
  }
  for (std::size_t tile = 1; tile < first_.size(); ++tile) first_[tile] += first_[tile - 1];
  objects_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t object = 0; object < objects.size(); ++object) {
    for_tiles(rects_[object], [&](std::uint32_t tile) { objects_[next[tile]++] = object; });
  }
}

std::vector<std::uint32_t> ObjectTiles::objects_in(const FilmRect& rect) const {
  std::vector<std::uint32_t> found;
  for_tiles(rect, [&](std::uint32_t tile) {
    std::copy_if(objects_.begin() + first_[tile], objects_.begin() + first_[tile + 1],
                 std::back_inserter(found), [&](std::uint32_t object) { return rects_[object].meets(rect); });
  });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace gvx::render
