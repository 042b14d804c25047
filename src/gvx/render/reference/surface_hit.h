/// \file
/// SurfaceHit: an opaque surface as an object of a ray: at one distance, of one colour. What surfaces a
/// picture shows is found before its rays march (surface/draw/surface_drawing.h).
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/render/frame/film_view.h"
#include "gvx/render/reference/composite.h"
#include "gvx/render/reference/object_march.h"
#include "gvx/render/reference/ray_segments.h"
#include "gvx/surface/draw/surface_film_view.h"

namespace gvx::render {

class SurfaceHit final : public ObjectMarch {
 public:
  /// What ray (x, y) of a film sees of surfaces.
  void set(const FilmView& film, const surface::SurfaceFilmView& surfaces, double x, double y) {
    const surface::SurfacePixel pixel =
        surfaces.at(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y));
    distance_ = FrameView::kNever;
    if (!pixel.seen()) return;
    color_ = pixel.color;
    distance_ = double(pixel.place) / dot(film.ray(x, y).ray.direction, film.camera.forward);
  }

  /// Is there one?
  bool seen() const { return distance_ < FrameView::kNever; }
  double distance() const { return distance_; }
  /// Its span is a point, which is within what it lies in.
  RaySpan span(std::uint32_t object) const { return {distance_, distance_, object}; }

  void begin(const BundleRay&) override {}
  bool projects() const override { return false; }
  void march_exact(RayState& state) const override { add(state, color_, 1); }
  void march_preview(RayState& state, PreviewPixel&) const override { add(state, color_, 1); }
  void march_projection(RayState&, double&, PreviewPixel*) const override {}
  double march_to(float, RayState& state) const override {
    add(state, color_, 1);
    return distance_;
  }
  bool look(double t, float, PreviewPixel*, ObjectStep& shown) override {
    shown = {};
    if (t > distance_) return true;
    shown.end = shown.surface = distance_;
    shown.color = color_;
    return true;
  }

 private:
  double distance_ = FrameView::kNever;
  Vec3f color_;
};

}  // namespace gvx::render
