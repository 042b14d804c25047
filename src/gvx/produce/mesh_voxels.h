/// \file
/// build_mesh_store: a triangle mesh into a .gvx store of colours and normals. Opacity is how much of a voxel
/// the mesh covers. The store is written in one pass and bounded memory: what is held is the mesh, its
/// hierarchy, and a few slices.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/exec/device.h"
#include "gvx/io/mesh.h"
#include "gvx/store/format.h"

namespace gvx::produce {

/// Is every edge of two triangles, so that there is an inside?
bool is_closed(const io::TriangleMesh& mesh);

struct MeshStoreOptions {
  std::int64_t resolution = 512;  ///< voxels along the longest side of the mesh
  /// What is inside is opaque; needs a mesh that is closed. Else the surface is made one and a half
  /// voxels thick.
  bool solid = false;
  std::uint32_t n = 2;   ///< children along an axis of a node: 2 or 3
  std::uint32_t m = 16;  ///< voxels along an axis of a brick: 8, 16 or 32
  store::Codec codec = store::Codec::zstd;
  std::uint64_t memory_bytes = 2ull << 30;  ///< bound of what the build holds at once, the mesh included
  std::string source;                       ///< the file's name, for the store and for errors
};

struct MeshStoreReport {
  Vec3i dimensions;
  std::uint64_t bytes_written = 0;
};

/// Writes the store to `path`, replacing what is there. On failure, and until all is written, `path` is as it
/// was. `progress` is called with slices that are done and all of them, from one thread.
Result<MeshStoreReport> build_mesh_store(const exec::Device& cpu, io::TriangleMesh mesh,
                                         const std::string& path, const MeshStoreOptions& options,
                                         const std::function<void(std::uint64_t, std::uint64_t)>& progress);

}  // namespace gvx::produce
