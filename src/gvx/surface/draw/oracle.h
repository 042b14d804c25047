/// \file
/// The oracle: by which technique a brick is drawn. Where its cells are wider than a pixel, or it has no
/// samples, triangles show it best. Otherwise it is the technique that takes the least time by a table of
/// costs: what they are of on this machine steers no picture that is to be exact.
#pragma once

#include <algorithm>
#include <cstdint>

#include "gvx/surface/draw/techniques.h"

namespace gvx::surface {

/// Nanoseconds, as measured with vectors of 16 lanes (docs/measurements).
struct TechniqueCosts {
  float triangle = 60, triangle_pixel = 40;  ///< of each, and of each pixel that it covers
  float sample = 100;                        ///< splatted, one after the other
  float cast_pixel = 35;                     ///< of each pixel of the brick's rectangle
  float steep = 1;  ///< by what share a cast takes longer where rays run along the grid, not across it
};

/// What the oracle knows of a brick in a picture.
struct BrickMeasures {
  std::uint64_t triangles = 0, samples = 0;
  double pixels = 0;       ///< of its rectangle
  double cell_pixels = 0;  ///< the width of a cell
  /// How much the rays run along the plane of the primary grid: 0 across it, to 1.
  double along_grid = 0;
  bool has_triangles = false, has_samples = false;
};

/// The widest cells that are shown as such, in pixels: the error is below a pixel.
inline constexpr double kWidestCell = 1;

inline Technique choose_technique(const BrickMeasures& brick, const TechniqueCosts& costs = {}) {
  if (!brick.has_samples) return Technique::rasterise;
  const double covered =
      std::min(brick.pixels, double(brick.samples) * brick.cell_pixels * brick.cell_pixels);
  const double cast = costs.cast_pixel * brick.pixels * (1 + costs.steep * brick.along_grid);
  const double splat = costs.sample * double(brick.samples);
  const double rasterise = costs.triangle * double(brick.triangles) + costs.triangle_pixel * covered;
  if (brick.has_triangles && (brick.cell_pixels > kWidestCell || rasterise < std::min(cast, splat)))
    return Technique::rasterise;
  return splat < cast ? Technique::splat : Technique::cast;
}

}  // namespace gvx::surface
