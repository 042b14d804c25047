/// \file
/// build_surface_store: a triangle mesh of any size into a surface store, within a bound of memory.
#pragma once

#include <cstdint>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/mesh/mesh_spool.h"
#include "gvx/mesh/surface_builder.h"
#include "gvx/store/format.h"

namespace gvx::mesh {

struct SurfaceStoreOptions {
  UpAxis up = UpAxis::z;  ///< of the mesh
  store::Codec codec = store::Codec::zstd;
  std::uint64_t memory_bytes = 1ull << 30;  ///< bound of what the build holds at once
  std::string source;                       ///< the file's name, for the store and for errors
};

struct SurfaceStoreReport {
  std::uint32_t levels = 0;
  std::uint64_t bricks = 0, samples = 0;
  double cell = 0;  ///< the edge of a cell of the finest level, in the mesh's units
  std::uint64_t bytes_written = 0;
};

/// Writes the store to `path`, replacing what is there, of a mesh that is finished. On failure, and until all
/// is written, `path` is as it was.
Result<SurfaceStoreReport> build_surface_store(const MeshSpool& mesh, const std::string& path,
                                               const SurfaceStoreOptions& options,
                                               const SurfaceProgress& progress = {});

}  // namespace gvx::mesh
