/// \file
/// PlacedBrick: a surface brick as a picture's camera sees it.
///
/// *Camera space* has x to the right, y up and z along the view, with the eye at 0. What is called depth is
/// z. A pixel's ray is eye + depth * way: its ways have z = 1, so that depth is the ray's own distance in
/// whatever space it is told.
#pragma once

#include <cstdint>

#include "gvx/core/affine.h"
#include "gvx/core/macros.h"
#include "gvx/core/ray.h"
#include "gvx/core/vec.h"
#include "gvx/scene/camera.h"
#include "gvx/surface/cell_set.h"

namespace gvx::surface {

/// The pixels of a film, for places in camera space.
struct FilmPlane {
  double pixel = 0;  ///< width of a pixel at depth 1, or anywhere if orthographic
  double half_width = 0, half_height = 0;
  bool orthographic = false;
  std::uint32_t width = 0, height = 0;

  FilmPlane() = default;
  FilmPlane(const scene::CameraView& camera, std::uint32_t width_, std::uint32_t height_)
      : pixel(camera.pixel),
        half_width(camera.half_width),
        half_height(camera.half_height),
        orthographic(camera.orthographic),
        width(width_),
        height(height_) {}

  /// The ray of pixel (x, y); its distance is depth.
  GVX_HD Ray ray(double x, double y) const {
    const double across = (x + 0.5 - half_width) * pixel, up = (half_height - y - 0.5) * pixel;
    return orthographic ? Ray{{across, up, 0}, {0, 0, 1}} : Ray{{}, {across, up, 1}};
  }
  /// The pixel that a place is seen in; whole numbers are the middles of pixels. Perspective: of a place
  /// before the eye.
  GVX_HD double x_of(Vec3d place) const { return place.x / width_at(place.z) + half_width - 0.5; }
  GVX_HD double y_of(Vec3d place) const { return half_height - 0.5 - place.y / width_at(place.z); }
  /// The width of a pixel at a depth.
  GVX_HD double width_at(double depth) const { return orthographic ? pixel : pixel * depth; }
};

/// From the world to camera space.
inline Affine3 world_to_camera(const scene::CameraView& camera) {
  const Vec3d &r = camera.right, &u = camera.up, &f = camera.forward;
  Affine3 turn{{{r.x, u.x, f.x}, {r.y, u.y, f.y}, {r.z, u.z, f.z}}, {}};
  turn.origin = -turn.vector(camera.eye);
  return turn;
}

/// Pixels first <= x < end, and so for y.
struct PixelRect {
  std::int32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  GVX_HD bool empty() const { return x0 >= x1 || y0 >= y1; }
  GVX_HD PixelRect operator&(const PixelRect& other) const {
    return {x0 > other.x0 ? x0 : other.x0, y0 > other.y0 ? y0 : other.y0, x1 < other.x1 ? x1 : other.x1,
            y1 < other.y1 ? y1 : other.y1};
  }
};

struct PlacedBrick {
  Affine3 to_camera;  ///< from cells of the brick
  Affine3 to_cells;   ///< and back

  /// A box of cells, as the film sees it: which pixels its rays may meet, and from which depth on.
  struct Seen {
    PixelRect rect;
    /// A cell before the box begins: nothing that the brick shows is nearer.
    double nearest = 0;
    /// The most that a cell may be wide, in pixels.
    double cell_pixels = 0;
  };

  /// `cells_to_camera` is for cells of the brick's level; the brick's corner is at `corner`, in these.
  static PlacedBrick at(const Affine3& cells_to_camera, Vec3d corner) {
    PlacedBrick brick{cells_to_camera, {}};
    brick.to_camera.origin = cells_to_camera.point(corner);
    brick.to_cells = inverse(brick.to_camera);
    return brick;
  }

  /// A film's ray in cells of the brick; its distance is depth.
  GVX_HD Ray ray(const Ray& of_film) const {
    return {to_cells.point(of_film.origin), to_cells.vector(of_film.direction)};
  }
};

/// What the film sees of cells `low` to `high`, both included, of the brick that `to_camera` is of. The
/// rectangle is empty where that is nothing.
PlacedBrick::Seen seen_of(const FilmPlane& film, const Affine3& to_camera, const std::uint8_t (&low)[3],
                          const std::uint8_t (&high)[3]);

}  // namespace gvx::surface
