/// \file
/// SurfaceSampler: from triangles to the cells of one surface brick (the orthogonal fragment buffer of
/// Buerger, Krueger, Westermann 2009, as section 3.2 of Reichl and others 2012 takes it).
///
/// Lines through the centres of all cells, along each of the three axes, are cut with the triangles. A cell
/// is found where a cut lies in it. Corners are rounded to parts of a cell and tests are exact, edges belong
/// to both triangles: so nothing is lost between triangles that share an edge, nor between bricks that share
/// a face. A closed surface then separates the cells: no path from cell to adjacent cell leads through it
/// beside those that were found.
#pragma once

#include <cstdint>

#include "gvx/core/vec.h"
#include "gvx/surface/sampled_cells.h"

namespace gvx::mesh {

/// A triangle in cells of the brick; what is outside of 0 to kCells is cut off.
struct SurfaceTriangle {
  Vec3d corner[3];
  Vec3f normal[3];  ///< unit
  Vec3f color[3];   ///< 0 to 1
};

class SurfaceSampler {
 public:
  /// Corners are rounded to this part of a cell.
  static constexpr int kParts = 512;
  /// No corner may be further from the brick than this many cells.
  static constexpr double kFarthest = 16384;

  void add(const SurfaceTriangle& triangle);
  const surface::SampledCells& samples() const { return samples_; }

 private:
  void add_along(int axis, const SurfaceTriangle& triangle, const Vec3<std::int64_t> (&corner)[3]);

  surface::SampledCells samples_;
};

}  // namespace gvx::mesh
