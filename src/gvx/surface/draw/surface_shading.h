/// \file
/// The colour and the exact place of what is seen of a surface in a pixel.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/scene/camera.h"
#include "gvx/scene/lighting.h"
#include "gvx/surface/draw/placed_brick.h"
#include "gvx/surface/draw/techniques.h"
#include "gvx/surface/draw/tile_hits.h"

namespace gvx::surface {

/// A picture's light, as surfaces of an object see it.
struct SurfaceLight {
  scene::LightingView lighting;
  scene::CameraView camera;
  /// Normals of the surface's cells to those of the world: the inverse of what places go through, transposed.
  Vec3d normal_row[3];

  SurfaceLight(const scene::LightingView& lighting_, const scene::CameraView& camera_,
               const Affine3& cells_to_world)
      : lighting(lighting_), camera(camera_) {
    const Affine3 back = inverse(cells_to_world);
    for (int i = 0; i < 3; ++i) normal_row[i] = back.column[i];
  }

  /// The normal as it is in the world; of any length.
  Vec3f normal_world(Vec3f normal) const {
    const Vec3d n(normal);
    return Vec3f(normalize(Vec3d(dot(normal_row[0], n), dot(normal_row[1], n), dot(normal_row[2], n))));
  }

  /// What a pixel shows of a surface of this colour.
  Vec3f shade(Vec3f normal, Vec3f color, double x, double y, double depth) const {
    const Ray ray = camera.pixel_ray_from_eye(x, y);
    const double distance = depth / dot(ray.direction, camera.forward);
    const Vec3f point(camera.eye + ray.at(distance));
    const scene::Shade<float> light =
        lighting.shade(normal_world(normal), 1.0f, -Vec3f(ray.direction), point);
    return color * light.body + light.glint;
  }
};

/// A place on a surface.
struct SurfacePoint {
  Vec3f normal, color;
  double depth = 0;
};

/// Of a sample that is seen at a depth: where the ray meets the plane through the cell's middle, as far as
/// that is within half of what a cell takes up in depth.
inline SurfacePoint point_of_sample(const SurfaceBrickView& brick, const PlacedBrick& placed,
                                    const Ray& of_film, Cell cell, double depth) {
  const Cell grid = GridAxes(brick.axis).to_grid(cell);
  const SampleAttributes& attributes = brick.attributes[brick.grid.rank(grid.x, grid.y, grid.z)];
  SurfacePoint point{normal_of(attributes), color_of(attributes), 0};
  const Ray ray = placed.ray(of_film);
  const Vec3d normal(point.normal);
  const double slope = dot(normal, ray.direction);
  double reach = 0;
  for (const Vec3d& column : placed.to_camera.column) reach += 0.5 * std::fabs(column.z);
  point.depth = depth;
  if (slope == 0) return point;
  const double meets = dot(normal, Vec3d(cell) + Vec3d(0.5) - ray.origin) / slope;
  point.depth = std::fmin(std::fmax(meets, depth - reach), depth + reach);
  return point;
}

inline SurfacePoint point_of_triangle(const TriangleListView& triangles, const PlacedBrick& placed,
                                      const Ray& of_film, bool orthographic, std::uint32_t triangle) {
  const SeenTriangle seen(placed, triangles, triangle);
  Vec3d weight(1.0 / 3);
  SurfacePoint point;
  seen.meets(of_film, orthographic, weight, point.depth);
  for (int i = 0; i < 3; ++i) {
    const SampleAttributes attributes = triangles.attributes(triangles.vertex(triangle, i));
    const auto share = static_cast<float>(weight[i]);
    point.normal = point.normal + share * normal_of(attributes);
    point.color = point.color + share * color_of(attributes);
  }
  // Normals that point against each other say nothing: then it is seen from the front.
  constexpr float kLeast = 1e-3f;
  const float size = length(point.normal);
  point.normal =
      size > kLeast ? point.normal / size : normal_of(triangles.attributes(triangles.vertex(triangle, 0)));
  return point;
}

}  // namespace gvx::surface
