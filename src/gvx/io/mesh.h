/// \file
/// Triangle meshes, and other programs' files of them: PLY, OBJ, STL, glTF.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx::io {

/// Every index is that of a vertex, and every vertex is finite.
struct TriangleMesh {
  std::vector<Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Vec3f> colors;  ///< of the vertices, display red, green, blue, 0 to 1; none: no colours

  /// The least box that holds all triangles.
  Box3d bounds() const;
};

struct MeshReport {
  std::uint64_t dropped = 0;  ///< triangles without an area, or of vertices that are no finite numbers
};

/// Reads the triangles of a file; polygons are cut up, points and lines left out, and the parts of a scene
/// put where it puts them. An error where the file cannot be read, its format is not known, or there is no
/// triangle in it.
Result<TriangleMesh> read_mesh(const std::string& path, MeshReport* report = nullptr);

/// Does the name end as that of a mesh that read_mesh() knows?
bool is_mesh_name(const std::string& path);

}  // namespace gvx::io
