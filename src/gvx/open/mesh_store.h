/// \file
/// build_mesh, build_mesh_surface: from a mesh file to a store of voxels, or of a surface.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/io/mesh.h"
#include "gvx/io/mesh_parts.h"
#include "gvx/mesh/mesh_voxels.h"
#include "gvx/mesh/surface_store.h"
#include "gvx/open/options.h"

namespace gvx::open {

/// What of a mesh is opaque: its inside, which a closed mesh has, or its surface. Automatic: the inside if
/// the mesh is closed.
enum class Fill : std::uint8_t { automatic, solid, shell };

/// How a mesh becomes voxels.
struct MeshBuild {
  mesh::MeshStoreOptions store;     ///< all but what the members below decide
  Fill fill = Fill::automatic;      ///< decides store.solid
  std::optional<UpAxis> up = {};    ///< the axis that points up; none: a guess
  std::string scratch_folder = {};  ///< empty: the folder of the store
};

struct BuiltMesh {
  mesh::MeshStoreReport store;
  io::MeshUp up;  ///< what the mesh itself says of the axis that points up
};

/// What a user should know of how a mesh was read, without a line end; empty where there is nothing to say.
/// `solid`: was it filled?
std::string mesh_notes(const mesh::MeshSummary& summary, bool solid);

struct BuiltSurface {
  mesh::SurfaceStoreReport store;
  io::MeshUp up;  ///< what the mesh itself says of the axis that points up
  std::uint64_t triangles = 0;
};

/// Reads the mesh and writes a store of its surface. Of `build` counts what does not speak of voxels.
Result<BuiltSurface> build_mesh_surface(const std::string& path, const std::string& output,
                                        const MeshBuild& build, const OpenOptions& options);

/// Reads the mesh and writes the store.
Result<BuiltMesh> build_mesh(const std::string& path, const std::string& output, MeshBuild build,
                             const OpenOptions& options);

}  // namespace gvx::open
