/// \file
/// SceneTile: the rays of a tile and the objects that they may meet. A ray goes from segment to segment
/// (ray_segments.h). Where its segment is one object, it is marched together with the tile's other rays that
/// stand before that object (tile_marcher.h), nearest objects first; where it is several, or the object is
/// small, it is marched by itself. Which of these it is, is a matter of geometry alone: so a ray's bits
/// depend neither on the other rays nor on what is resident.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gvx/exec/tile_grid.h"
#include "gvx/render/reference/scene_ray.h"
#include "gvx/render/reference/surface_hit.h"
#include "gvx/render/tile/object_tiles.h"
#include "gvx/render/tile/tile_march.h"
#include "gvx/render/tile/tile_rays.h"

namespace gvx::render {

class SceneTile {
 public:
  /// The rays `marching` of a tile.
  SceneTile(const Pass& pass, const ObjectTiles& objects, const RaysOfTile& rays, const ActiveRays& marching);

  /// Marches them until none can go on, or the deadline. There is a state, and for previews a pixel, for each
  /// ray of a whole tile; `pixels` is null for exact rays.
  void march(RayState* states, PreviewPixel* pixels, exec::Deadline deadline);

 private:
  /// An object on the film.
  struct Object {
    const ObjectView* view;  // null: the surfaces
    FilmRect rect;
    bool in_vectors;  // as far as it is by itself
    bool projects;
    double nearest = 1e300;   // distance of the rays' spans
    ActiveRays waiting = {};  // rays that stand before it, alone
  };

  void put_spans(const ActiveRays& marching);
  void put_surface(std::uint32_t ray) { surface_->set(pass_.film, pass_.surfaces, x_of(ray), y_of(ray)); }
  double x_of(std::uint32_t ray) const { return rays_.x0 + rays_.apart * double(ray % TileRays::kEdge); }
  double y_of(std::uint32_t ray) const {
    const std::uint32_t row = ray / TileRays::kEdge;
    return rays_.y0 + rays_.apart * row;
  }
  BundleRay ray_of(std::uint32_t ray) const { return pass_.film.ray(x_of(ray), y_of(ray)); }
  bool has_late_ray();
  void go_on(std::uint32_t ray);
  void put_projection(std::uint32_t ray, RayThroughObjects& through);
  void march_waiting(std::uint32_t index);
  void project(std::uint32_t index, const ActiveRays& rays);

  const Pass& pass_;
  const RaysOfTile rays_;
  std::vector<Object> objects_;
  std::vector<std::unique_ptr<ObjectMarch>> marches_;  // of objects_
  SurfaceHit* surface_ = nullptr;                      // of marches_, the last; null: there are none
  std::vector<std::uint32_t> by_distance_;             // objects_, the nearest first
  ActiveRays marching_;
  std::vector<RaySpan> spans_;        // of all rays
  std::vector<std::uint32_t> first_;  // of each ray, in spans_; and their number
  RayState* states_ = nullptr;
  PreviewPixel* pixels_ = nullptr;
  exec::Deadline deadline_;
  int begun_ = 0;               // segments of rays by themselves
  std::size_t projecting_ = 0;  // objects
  RayProjection projection_;    // a preview's
  std::vector<ProjectedSample> samples_;
  std::vector<RayState> gathering_;  // of rays that are projected together
};

}  // namespace gvx::render
