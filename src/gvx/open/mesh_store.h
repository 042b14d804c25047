/// \file
/// build_mesh: from a mesh file to a store.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/io/mesh.h"
#include "gvx/io/mesh_parts.h"
#include "gvx/mesh/mesh_voxels.h"
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

/// Reads the mesh and writes the store.
Result<BuiltMesh> build_mesh(const std::string& path, const std::string& output, MeshBuild build,
                             const OpenOptions& options);

}  // namespace gvx::open
