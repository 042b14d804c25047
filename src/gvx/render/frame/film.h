/// \file
/// Film: the rays and preview pixels of one picture, and the picture that they make.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/exec/tile_grid.h"
#include "gvx/render/frame/frame.h"
#include "gvx/render/frame/ray_projection.h"
#include "gvx/render/frame/ray_state.h"
#include "gvx/surface/draw/surface_film_view.h"

namespace gvx::render {

/// A finished picture: display (sRGB) red, green, blue and alpha, 0 to 1, not multiplied by alpha; rows from
/// the top.
struct Picture {
  std::uint32_t width = 0, height = 0;
  std::vector<float> rgba;

  std::vector<std::uint8_t> to_8_bit() const;
  /// Colours in linear light, multiplied by alpha, as EXR files hold them.
  std::vector<float> to_linear_premultiplied() const;
};

/// Memory of the caller's that rows of pixels are written into, from the top.
template <typename T>
struct PictureRows {
  std::span<T> values;
  std::size_t stride = 0;  ///< from the start of a row to that of the next, in values; 0: no gap between rows
};

/// Where a picture is to be put; what has no memory is left out.
struct PictureTarget {
  PictureRows<std::uint8_t> rgba8 = {};  ///< as Picture::to_8_bit(): four values a pixel
  PictureRows<float> rgba = {};          ///< as Picture::rgba: four values a pixel
  /// One value a pixel: how far, along the view and in the world's units, what is seen there is from the eye.
  /// Infinite where the pixel shows less than half of anything.
  PictureRows<float> depth = {};
  /// One value a pixel: which object is seen where that depth is; -1 where there is none.
  PictureRows<std::int32_t> object = {};
};

/// An error that says which rows of a picture of this size do not fit into their memory.
Status check(const PictureTarget& target, std::uint32_t width, std::uint32_t height);

/// Peak signal-to-noise ratio of the colours, held to 0 to 1, peak 1, in decibels; infinite where they are
/// equal. For pictures of one size.
double psnr(const Picture& a, const Picture& b);

/// What the pixels of a film add up to.
struct FilmTotals {
  std::uint64_t samples = 0;     ///< taken by exact rays
  std::uint64_t unfinished = 0;  ///< exact rays
  std::uint64_t wanted = 0;      ///< stretches of preview rays that wanted data
  std::uint64_t resident = 0;    ///< of these, those that had it at the level wanted
  std::uint32_t worst_lack = 0;  ///< the most levels by which one fell short
};

class Film {
 public:
  /// The largest block of a preview's first stage.
  static constexpr std::uint32_t kLargestBlock = 32;

  /// Of width x height rays.
  /// Of a scene in which `projecting` objects beside others show a greatest, least or mean value.
  Film(const exec::Device& device, std::uint32_t width, std::uint32_t height, std::uint32_t projecting = 0);

  exec::TileGrid grid() const { return {width_, height_}; }
  exec::BufferView<RayState> rays() { return rays_.view(); }
  exec::BufferView<PreviewPixel> preview() { return preview_.view(); }
  /// Of each tile of the grid the epoch in which it was found that none of its rays sees anything: then these
  /// are finished, and their states are not written, which are most of what a picture takes in memory.
  exec::BufferView<std::uint32_t> blank_tiles() { return blank_tiles_.view(); }

  /// Pass::projections.
  ProjectionsView projections() { return {projections_.view(), samples_.view(), projecting_}; }

  /// What each ray sees of opaque surfaces; it must stay valid. Rays that have marched have it in their
  /// states already: it is shown where none does, and where all is surfaces (`only`) everywhere.
  void show_surfaces(const surface::SurfaceFilmView& surfaces, bool only) {
    surfaces_ = surfaces;
    only_surfaces_ = only;
  }

  /// All rays back to their start and no preview: a new epoch.
  void clear() { ++epoch_; }
  /// What rays and preview pixels of this picture carry; others count as not there.
  std::uint32_t epoch() const { return epoch_; }

  /// How pixels are made of rays.
  struct Development {
    std::uint32_t rays_per_axis = 1;
    Vec3f background;
    bool opaque_background = true;  ///< otherwise pixels keep their alpha
  };
  /// Pixels of rays_per_axis^2 rays each: finished rays as they are; the rest as a preview pixel whose block
  /// they are in, of the newest generation and then of the finest block; else nothing. On the threads of
  /// `cpu`.
  Picture develop(const exec::Device& cpu, const Development& how) const;
  /// The same into the target's colours, which must fit: check(). Depth is not a film's to know.
  void develop(const exec::Device& cpu, const Development& how, const PictureTarget& target) const;

  /// The opacity of what pixel (x, y) shows of the volume.
  float opacity(std::uint32_t rays_per_axis, std::uint32_t x, std::uint32_t y) const;

  FilmTotals totals() const;
  /// Of what the preview's rays of blocks of this size wanted, the share that they had; 1 before any ran.
  double resident_share(std::uint32_t block) const;

 private:
  /// Colour, multiplied by its opacity, and opacity.
  struct Seen {
    Vec3f color;
    float opacity = 0;
  };
  Seen seen(std::uint32_t x, std::uint32_t y) const;
  Seen seen_of_surfaces(std::uint32_t x, std::uint32_t y) const;
  Seen seen_in_preview(std::uint32_t x, std::uint32_t y) const;
  Seen mean_of(std::uint32_t rays_per_axis, std::uint32_t x, std::uint32_t y) const;
  bool is_blank(std::uint32_t x, std::uint32_t y) const {
    return blank_tiles_.view()[grid().tile_of(x, y)] == epoch_;
  }

  std::uint32_t width_, height_;
  std::uint32_t epoch_ = 1;
  exec::Buffer<RayState> rays_;
  exec::Buffer<PreviewPixel> preview_;
  exec::Buffer<std::uint32_t> blank_tiles_;
  surface::SurfaceFilmView surfaces_;
  bool only_surfaces_ = false;
  std::uint32_t projecting_;
  exec::Buffer<RayProjection> projections_;
  exec::Buffer<ProjectedSample> samples_;
};

}  // namespace gvx::render
