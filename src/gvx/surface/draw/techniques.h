/// \file
/// The three techniques by which a brick is drawn into a tile, the plain way, which says what the vectors
/// must find (Reichl, Chajdas, Buerger, Westermann 2012, sections 4.1 and 4.2):
///
/// - *cast*: each pixel's ray goes through the primary grid (cast.h);
/// - *splat*: each sample is tested against the rays of the few pixels that its cell may cover;
/// - *rasterise*: each triangle is put into the pixels whose rays meet it.
///
/// Casts and splats find the same. What a sample's depth is compared by lies half way between where a ray
/// enters its cell and where it leaves it.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/surface/draw/placed_brick.h"
#include "gvx/surface/draw/tile_hits.h"
#include "gvx/surface/surface_brick.h"
#include "gvx/surface/triangle_list.h"

namespace gvx::surface {

enum class Technique : std::uint8_t { cast, splat, rasterise };

/// What is drawn, into which pixels.
struct DrawnSamples {
  const FilmPlane& film;
  const PlacedBrick& placed;
  const SurfaceBrickView& brick;
  std::uint32_t number;                         ///< of the brick
  PixelRect part;                               ///< of the tile, that the brick may be seen in
  double nearest = 0;                           ///< the depth that the brick begins at, or less
  Box3d box{{0, 0, 0}, Vec3d(double(kCells))};  ///< that its samples are in, in cells
};
struct DrawnTriangles {
  const FilmPlane& film;
  const PlacedBrick& placed;
  const TriangleListView& triangles;
  std::uint32_t number;
  PixelRect part;
  double nearest = 0;  ///< what is nearer is other bricks' to show
};

void cast_samples(const DrawnSamples& drawn, TileHits& hits);
void splat_samples(const DrawnSamples& drawn, TileHits& hits);
/// What of triangles lies beyond the brick's pixels, or before it, is left to the bricks that it is in.
void rasterise(const DrawnTriangles& drawn, TileHits& hits);
/// One of them.
void rasterise_one(const DrawnTriangles& drawn, std::uint32_t triangle, TileHits& hits);

/// A triangle in camera space, as rays see it (homogeneous edge functions: Olano and Greer 1997). An edge
/// that two triangles share has opposite numbers in them, to the last bit: no ray passes between them.
struct SeenTriangle {
  Vec3d corner[3];
  Vec3d edge[3];      ///< the plane through the eye and the edge opposite to a corner
  double volume = 0;  ///< of what lies between the triangle and the eye, times 6

  SeenTriangle(const PlacedBrick& placed, const TriangleListView& triangles, std::uint32_t triangle) {
    for (int i = 0; i < 3; ++i) {
      const Vec3d parts(triangles.place(triangles.vertex(triangle, i)));
      corner[i] = placed.to_camera.point(parts * (1.0 / kCellParts));
    }
    for (int i = 0; i < 3; ++i) edge[i] = cross(corner[(i + 1) % 3], corner[(i + 2) % 3]);
    volume = dot(corner[0], edge[0]);
  }

  /// Does a film's ray meet it? The weights of its corners, which add up to 1, and the depth are those of its
  /// plane in any case.
  bool meets(const Ray& ray, bool orthographic, Vec3d& weight, double& depth) const {
    for (int i = 0; i < 3; ++i) {
      if (orthographic) {
        const Vec3d a = corner[(i + 1) % 3] - ray.origin, b = corner[(i + 2) % 3] - ray.origin;
        weight[i] = a.x * b.y - a.y * b.x;
      } else {
        weight[i] = dot(ray.direction, edge[i]);
      }
    }
    const bool inside = min_component(weight) >= 0 || max_component(weight) <= 0;
    const double sum = weight.x + weight.y + weight.z;
    weight = weight / sum;
    depth = orthographic ? dot(weight, Vec3d(corner[0].z, corner[1].z, corner[2].z)) : volume / sum;
    return inside && depth > 0 && depth < INFINITY;
  }
};

}  // namespace gvx::surface
