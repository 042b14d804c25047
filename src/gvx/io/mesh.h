/// \file
/// Triangle meshes, and other programs' files of them: PLY, OBJ, STL, glTF.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx::io {

/// Its corners' vertices.
using Triangle = std::array<std::uint32_t, 3>;

/// Does a triangle cover anything? Not where a corner is no finite place or all lie on a line.
bool has_area(Vec3f a, Vec3f b, Vec3f c);

/// Every index is that of a vertex, and every vertex is finite.
struct TriangleMesh {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
  std::vector<Vec3f> colors;  ///< of the vertices, display red, green, blue, 0 to 1; none: no colours

  /// The least box that holds all triangles.
  Box3d bounds() const;
};

/// Takes a mesh of any size piece by piece.
class MeshSink {
 public:
  virtual ~MeshSink() = default;

  /// The next vertices, and their colours, or none for all of the mesh. What files say: places may be no
  /// finite numbers; colours are 0 to 1.
  virtual Status add_vertices(std::span<const Vec3f> places, std::span<const Vec3f> colors) = 0;

  /// The next triangles, of vertices that came before. What files say: an index may be that of none.
  virtual Status add_triangles(std::span<const Triangle> triangles) = 0;
};

/// Called with what is read of all there is, in vertices and polygons.
using MeshProgress = std::function<void(std::uint64_t done, std::uint64_t all)>;

/// Hands a file's triangles over as it is read; polygons are cut up, points and lines left out, and the parts
/// of a scene put where it puts them. PLY takes no memory but its buffers; other formats are whole in memory
/// before the first triangle. An error where the file cannot be read or its format is not known.
Status stream_mesh(const std::string& path, MeshSink& sink, const MeshProgress& progress = {});

struct MeshReport {
  std::uint64_t dropped = 0;  ///< triangles without an area, or of vertices that are no finite numbers
};

/// Reads the triangles of a file as stream_mesh() does, all into memory; an error also where there is none in
/// it.
Result<TriangleMesh> read_mesh(const std::string& path, MeshReport* report = nullptr);

/// Does the name end as that of a mesh that read_mesh() knows?
bool is_mesh_name(const std::string& path);

}  // namespace gvx::io
