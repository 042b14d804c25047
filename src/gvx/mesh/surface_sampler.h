/// \file
/// SurfaceSampler: from triangles to the cells of one surface brick (the orthogonal fragment buffer of
/// Buerger, Krueger, Westermann 2009, as section 3.2 of Reichl and others 2012 takes it).
///
/// Lines through the centres of all cells, along each of the three axes, are cut with the triangles. A cell
/// is found where a cut lies in it. Corners are whole parts of a cell and tests are exact, edges belong to
/// both triangles: so nothing is lost between triangles that share an edge, nor between bricks that share a
/// face. A closed surface then separates the cells: no path from cell to adjacent cell leads through it
/// beside those that were found.
#pragma once

#include <array>
#include <cstdint>
#include <utility>

#include "gvx/core/vec.h"
#include "gvx/mesh/corner_normals.h"
#include "gvx/mesh/mesh_spool.h"
#include "gvx/surface/sampled_cells.h"
#include "gvx/surface/triangle_list.h"

namespace gvx::mesh {

/// Corners are rounded to this part of a cell.
inline constexpr std::int64_t kCellParts = surface::kCellParts;
/// No corner may be further from a brick than this many parts: products of two such ways are whole numbers.
inline constexpr std::int64_t kFarthestParts = std::int64_t{1} << 29;

/// A triangle as a brick sees it; what is outside of 0 to kCells is cut off.
struct SurfaceTriangle {
  Vec3<std::int32_t> corner[3];  ///< parts of a cell, from the brick's corner on
  Normal16 normal[3];            ///< 0 where there is none: then it is the triangle's own
  Rgb8 color[3];

  /// As a brick's list has them.
  std::array<surface::TriangleVertex, 3> vertices() const;
};

class SurfaceSampler {
 public:
  void add(const SurfaceTriangle& triangle);
  /// The cells that its corners are in, of a triangle that lies between all lines.
  void add_corners(const SurfaceTriangle& triangle);
  const surface::SampledCells& samples() const { return samples_; }
  /// What was found; from then on there is nothing.
  surface::SampledCells take() { return std::exchange(samples_, surface::SampledCells()); }

 private:
  void add_along(int axis, const SurfaceTriangle& triangle);

  surface::SampledCells samples_;
};

}  // namespace gvx::mesh
