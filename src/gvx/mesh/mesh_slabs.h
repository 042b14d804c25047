/// \file
/// MeshSlabs: a mesh of any size sorted into slabs of voxels, each of which fits memory with all that is near
/// to it.
///
///     spool: triangles    corners by place    normals by triangle     slabs: triangles with normals
///     in file's order  -> (external sort)  -> (external sort)      -> that are near to each, in file's order
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/scratch_file.h"
#include "gvx/mesh/corner_normals.h"
#include "gvx/mesh/mesh_spool.h"

namespace gvx::mesh {

/// In space of voxels: voxel i covers i to i + 1.
struct SlabTriangle {
  std::array<Vec3f, 3> corners;
  std::array<Normal16, 3> normals;
  std::array<Rgb8, 3> colors;
};

/// Called with what is being done, and how much of it: "sorting", in any unit, then "building", in voxels.
using MeshBuildProgress = std::function<void(const char* what, std::uint64_t done, std::uint64_t all)>;

class MeshSlabs {
 public:
  /// Rows y of slices z, whole along x.
  struct Slab {
    std::int64_t z_begin = 0, z_end = 0, y_begin = 0, y_end = 0;
    std::uint64_t first = 0, count = 0;  ///< of the triangles
  };

  struct Space {
    Vec3d origin;      ///< the corner of voxel 0
    double voxel = 1;  ///< its edge
    Vec3i dimensions;
  };

  /// Slices and rows are cut at multiples of this.
  static constexpr std::int64_t kBlock = 8;

  /// Sorts within memory_bytes a mesh that is in the space's voxels. No slab has more than `most` triangles
  /// in it or within two voxels of it; nothing where one of kBlock slices and a sixty-fourth of the rows has.
  static Result<std::optional<MeshSlabs>> sort(const MeshSpool& mesh, const Space& space,
                                               std::uint64_t memory_bytes, std::uint64_t most,
                                               const MeshBuildProgress& progress);

  /// By z, then y; they cover all voxels, and those of equal slices follow each other.
  const std::vector<Slab>& slabs() const { return slabs_; }

  /// Triangles of a slab that are near to it, from the one with this index of the slab's on, as many as `out`
  /// takes; in the mesh's order.
  Status read(const Slab& slab, std::uint64_t index, std::span<SlabTriangle> out) const;

 private:
  MeshSlabs(std::vector<Slab> slabs, io::ScratchFile triangles)
      : slabs_(std::move(slabs)), triangles_(std::move(triangles)) {}

  std::vector<Slab> slabs_;
  io::ScratchFile triangles_;
};

}  // namespace gvx::mesh
