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
#include "gvx/core/up_axis.h"
#include "gvx/core/vec.h"

namespace gvx::io {

/// Its corners' vertices.
using Triangle = std::array<std::uint32_t, 3>;

/// Does a triangle cover anything? Not where a corner is no finite place or all lie on a line.
bool has_area(Vec3d a, Vec3d b, Vec3d c);

/// Every index is that of a vertex, and every vertex is finite.
struct TriangleMesh {
  std::vector<Vec3f> vertices;  ///< from `origin` on
  std::vector<Triangle> triangles;
  std::vector<Vec3f> colors;  ///< of the vertices, display red, green, blue, 0 to 1; none: no colours
  /// Not 0 where a mesh is so far from 0 that single precision would lose its shape.
  Vec3d origin;

  Vec3d place(std::uint32_t vertex) const { return origin + Vec3d(vertices[vertex]); }

  /// The least box that holds all triangles, at their places.
  Box3d bounds() const;
};

/// Takes a mesh of any size piece by piece.
class MeshSink {
 public:
  virtual ~MeshSink() = default;

  /// The next vertices, with a colour for each, 0 to 1 as displayed, or no colours at all. Places are as the
  /// file says: they may not be finite.
  virtual Status add_vertices(std::span<const Vec3d> places, std::span<const Vec3f> colors) = 0;

  /// The next triangles, of vertices that came before, with a colour for each, or none where the vertices'
  /// count. Indices are as the file says: there may be no such vertex.
  virtual Status add_triangles(std::span<const Triangle> triangles, std::span<const Vec3f> colors = {}) = 0;

  /// The place of a vertex that came before; NaN where there is none of this index.
  virtual Result<Vec3d> place(std::uint32_t vertex) = 0;

  /// Is told what is not used of a file, such as "textures".
  virtual void pass_over(const std::string& what) = 0;
};

/// Cuts a polygon of vertices that the sink has into triangles, which are appended.
Status cut_polygon(MeshSink& sink, std::span<const std::uint32_t> corners, std::vector<Triangle>& triangles);

/// Called with how much is read, and of how much, in units that depend on the format.
using MeshProgress = std::function<void(std::uint64_t done, std::uint64_t all)>;

/// Hands a file's triangles over as it is read; polygons are cut up, points and lines left out, and the parts
/// of a scene put where it puts them. PLY, OBJ and STL take no memory but their buffers; glTF is whole in
/// memory before the first triangle. An error where the file cannot be read or its format is not known.
Status stream_mesh(const std::string& path, MeshSink& sink, const MeshProgress& progress = {});

struct MeshReport {
  std::uint64_t dropped = 0;  ///< triangles without an area, or of vertices that are no finite numbers
};

/// Reads the triangles of a file as stream_mesh() does, all into memory; colours of triangles are left out.
/// An error also where there is none in it.
Result<TriangleMesh> read_mesh(const std::string& path, MeshReport* report = nullptr);

/// The error for a file of which no triangle is left, after `dropped` were left out.
Error no_triangle(const std::string& path, std::uint64_t dropped);

/// Which axis of a mesh points up, and why that is so or likely: "as in most STL files".
struct MeshUp {
  UpAxis axis = UpAxis::z;
  bool guessed = true;  ///< glTF alone says it
  std::string why;
};

/// Of a mesh file with these bounds. In glTF y is up (2.0, 3.4). In other formats the first of these counts:
/// - x and y are more than ten times the mesh's size from 0, as on a map: z is up;
/// - the mesh begins at y = 0 and 0 is in the middle half of its z: it stands on that plane, and y is up; or
///   the same with y and z exchanged;
/// - the habit of the programs that write the format: y is up in OBJ and PLY, z in STL.
MeshUp mesh_up(const std::string& path, const Box3d& bounds);

/// Does the name end as that of a mesh that read_mesh() knows?
bool is_mesh_name(const std::string& path);

}  // namespace gvx::io
