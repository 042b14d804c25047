/// \file
/// build_mesh_store: a triangle mesh of any size into a .gvx store of colours and normals. Opacity is how
/// much of a voxel the mesh covers. The store is written in one pass and bounded memory: what is held is a
/// few slices of voxels, and the triangles near to a slab of them with their hierarchy.
#pragma once

#include <cstdint>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/exec/device.h"
#include "gvx/mesh/mesh_slabs.h"
#include "gvx/mesh/mesh_spool.h"
#include "gvx/store/format.h"

namespace gvx::mesh {

struct MeshStoreOptions {
  std::int64_t resolution = 512;  ///< voxels along the longest side of the mesh
  /// What is inside is opaque; needs a mesh that is closed. Else the surface is made one and a half
  /// voxels thick.
  bool solid = false;
  UpAxis up = UpAxis::z;  ///< of the mesh
  std::uint32_t n = 2;    ///< children along an axis of a node: 2 or 3
  std::uint32_t m = 16;   ///< voxels along an axis of a brick: 8, 16 or 32
  store::Codec codec = store::Codec::zstd;
  std::uint64_t memory_bytes = 2ull << 30;  ///< bound of what the build holds at once
  std::string source;                       ///< the file's name, for the store and for errors
};

struct MeshStoreReport {
  Vec3i dimensions;
  std::uint64_t bytes_written = 0;
  std::size_t slabs = 0;  ///< that the mesh was sorted into
};

/// Writes the store to `path`, replacing what is there, of a mesh that is finished. On failure, and until all
/// is written, `path` is as it was. `progress` is called from one thread.
Result<MeshStoreReport> build_mesh_store(const exec::Device& cpu, const MeshSpool& mesh,
                                         const std::string& path, const MeshStoreOptions& options,
                                         const MeshBuildProgress& progress);

}  // namespace gvx::mesh
