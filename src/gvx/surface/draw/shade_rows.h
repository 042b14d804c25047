/// \file
/// Shading of a film's rows over vectors of pixels: surface_shading.h once more, in camera space and floats.
#pragma once

#include <cstdint>
#include <span>

#include "gvx/scene/lighting.h"
#include "gvx/surface/draw/placed_brick.h"
#include "gvx/surface/draw/surface_film_view.h"
#include "gvx/surface/draw/surface_overlay.h"
#include "gvx/surface/draw/techniques.h"
#include "gvx/surface/surface_brick.h"
#include "gvx/surface/triangle_list.h"

namespace gvx::surface {

/// A brick of which something is seen.
struct SeenBrick {
  bool there = false;  ///< are its pieces in memory? If not, its pixels are left as they are
  bool by_triangles = false;
  Technique technique = Technique::cast;
  std::int32_t object = 0;
  std::uint32_t instance = 0;
  SurfaceBrickView samples;
  TriangleListView triangles;
  PlacedBrick placed;
  Vec3f corner, cell[3];  ///< its corner and the ways along its cells, in camera space
};

/// Of an instance: from normals of its cells to those of camera space, as rows; the lengths do not matter.
struct NormalsToCamera {
  Vec3f row[3];

  NormalsToCamera() = default;
  explicit NormalsToCamera(const Affine3& cells_to_camera);
};

/// What rows are shaded by.
struct RowShading {
  FilmPlane film;
  scene::Lighting lighting;
  Vec3f light[scene::Lighting::kMostLights];  ///< unit directions, or places, in camera space
  std::span<const SeenBrick> bricks;          ///< by SurfacePixel::brick
  std::span<const NormalsToCamera> normals;   ///< of instances
  Overlay overlay = Overlay::none;
};

/// The colour that an overlay gives a pixel.
Vec3f overlay_color(Overlay overlay, const SeenBrick& brick, std::uint32_t item);

/// Shades the pixels x0 to x1 - 1 of row y that are seen, not shaded, and whose bricks are there; row[x] is
/// pixel x.
void shade_row(const RowShading& shading, SurfacePixel* row, std::uint32_t y, std::uint32_t x0,
               std::uint32_t x1);

}  // namespace gvx::surface
