/// \file
/// SeenSurfaces: the surfaces of a world as one view of it shows them: drawn, and what it lacks of them named
/// as the cache calls it.
#pragma once

#include <vector>

#include "gvx/core/result.h"
#include "gvx/engine/cache.h"
#include "gvx/engine/world.h"
#include "gvx/exec/device.h"
#include "gvx/render/frame/film_view.h"
#include "gvx/render/frame/view.h"
#include "gvx/surface/draw/surface_drawing.h"

namespace gvx::engine {

/// An error where a camera is so far away, for its angle, that depths of surfaces are rounded by more than
/// about a tenth of a pixel's width: which is before which could not be told.
Status check_distance(const render::FilmView& film, const World& world);

class SeenSurfaces {
 public:
  /// Of the surfaces of a world that has some, which must outlive this; on the threads of `cpu`.
  SeenSurfaces(const exec::Device& cpu, const render::View& view, const render::FilmView& film,
               const World& world);

  /// Another view of a world, in the same memory where the film is of the same size.
  void see(const render::View& view, const render::FilmView& film, const World& world);

  // For the viewer that has the cache's turn:

  /// Draws what came, as SurfaceDrawing::advance(); returns what it lacks.
  std::vector<Cache::SurfaceElement> advance() { return elements_of(drawing_.advance()); }
  /// Draws all with what is in memory.
  std::vector<Cache::SurfaceElement> draw_resident() { return elements_of(drawing_.draw_resident()); }

  bool complete() const { return drawing_.complete(); }
  surface::SurfaceFilmView film() const { return drawing_.film(); }
  const surface::SurfaceCounts& counts() const { return drawing_.counts(); }

 private:
  std::vector<Cache::SurfaceElement> elements_of(const std::vector<surface::LackingElement>& lacking) const;

  std::vector<Surface*> surfaces_;  // of each instance
  surface::SurfaceDrawing drawing_;
};

}  // namespace gvx::engine
