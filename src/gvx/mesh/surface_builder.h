/// \file
/// build_surface: from a mesh of any size to surface bricks of all levels, within a bound of memory.
///
///     spool: triangles, in the file's order
///     -> normals of corners, by external sorts
///     -> a record for each triangle and brick that it meets
///     -> these in the tree's order, by an external sort
///     -> SurfacePyramid: bricks of all levels
#pragma once

#include <cstdint>
#include <functional>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/mesh/mesh_spool.h"
#include "gvx/surface/surface_pyramid.h"

namespace gvx::mesh {

/// The cube that a surface's tree divides.
struct SurfaceSpace {
  Vec3d origin;     ///< its corner
  double cell = 1;  ///< the edge of a cell of the finest level, in the mesh's units
  std::uint32_t finest_level = 0;

  double brick() const { return cell * surface::kCells; }
};

/// The finest level of a tree that may be built: its corners are no further from any brick than
/// kFarthestParts.
inline constexpr std::uint32_t kFinestSurface = 14;

/// The edge of cells at which samples take about as many bytes as triangles: 0.7 times the median of the
/// triangles' median edges. (Reichl and others 2012 take half the smallest triangle, which is a sliver in
/// most scans.) Edges are told apart by 3 %.
Result<double> cell_of(const MeshSpool& mesh);

/// The least cube for cells of this edge or, where that would be more levels than can be built, of larger
/// ones.
SurfaceSpace surface_space(const MeshSummary& mesh, double cell);

/// Called with what is being done, and how much of it, in triangles.
using SurfaceProgress = std::function<void(const char* what, std::uint64_t done, std::uint64_t all)>;

/// Makes all bricks of a mesh that has triangles. What is made does not depend on memory_bytes.
Status build_surface(const MeshSpool& mesh, const SurfaceSpace& space, std::uint64_t memory_bytes,
                     const surface::SurfacePyramid::Take& take, const SurfaceProgress& progress = {});

}  // namespace gvx::mesh
