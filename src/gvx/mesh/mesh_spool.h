/// \file
/// MeshSpool: a mesh of any size, of which the triangles wait on disk with all that is theirs, and what is
/// known of it as a whole.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/io/mesh.h"
#include "gvx/io/scratch_file.h"
#include "gvx/mesh/mesh_inside.h"

namespace gvx::mesh {

/// Display red, green and blue.
using Rgb8 = std::array<std::uint8_t, 3>;

/// What meshes without colours have.
inline constexpr Rgb8 kPlainColor = {204, 204, 204};

/// A triangle that needs no vertices elsewhere.
struct SpooledTriangle {
  std::array<Vec3d, 3> corners;
  std::array<Rgb8, 3> colors;
};

/// Its corners, counted from `origin` in units of this length, with as many digits as floats have.
inline std::array<Vec3f, 3> corners_in(const SpooledTriangle& triangle, Vec3d origin, double unit) {
  std::array<Vec3f, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) corners[i] = Vec3f((triangle.corners[i] - origin) / unit);
  return corners;
}

struct MeshSummary {
  std::uint64_t vertices = 0;                       ///< whether a triangle has them or not
  std::uint64_t triangles = 0;                      ///< that cover anything
  std::uint64_t dropped = 0;                        ///< the others, and those of vertices that are not there
  std::uint64_t doubled = 0;                        ///< that are left out because the same face is there
  Box3d bounds{Vec3d(INFINITY), Vec3d(-INFINITY)};  ///< of the triangles
  bool colors = false;
  Vec3f mean_color;  ///< of the surface
  InsideRule inside = InsideRule::none;
  std::vector<std::string> unused;  ///< what of the file is not used, each once

  /// Does the mesh have an inside?
  bool closed() const { return inside != InsideRule::none; }
};

/// One thread fills it, then finishes it. Vertices wait on disk, too, and as many as fit half of the memory
/// are read again in blocks: where triangles jump about among more of them than that, each corner is a read.
class MeshSpool final : public io::MeshSink {
 public:
  /// Its scratch files stand in `folder`.
  static Result<std::unique_ptr<MeshSpool>> create(const std::string& folder, std::uint64_t memory_bytes);

  Status add_vertices(std::span<const Vec3d> places, std::span<const Vec3f> colors) override;
  Status add_triangles(std::span<const io::Triangle> triangles, std::span<const Vec3f> colors = {}) override;
  Result<Vec3d> place(std::uint32_t vertex) override;
  void pass_over(const std::string& what) override;

  /// To be called after the last triangle.
  Status finish();

  /// What it all is, once it is finished.
  const MeshSummary& summary() const { return summary_; }

  /// In the file's order, once it is finished.
  const io::ScratchList<SpooledTriangle>& triangles() const { return *triangles_; }

  const std::string& folder() const { return folder_; }

 private:
  struct Vertex {
    Vec3d place;
    Rgb8 color;
  };

  /// Vertices that were read together; of a list that still grew, perhaps fewer than a block holds.
  struct Block {
    std::uint64_t number = UINT64_MAX;
    std::size_t vertices = 0;
  };

  MeshSpool(std::string folder, std::uint64_t memory_bytes, io::ScratchList<Vertex> vertices,
            io::ScratchList<SpooledTriangle> triangles, io::ScratchList<EdgeSums::Corners> slivers);

  /// Makes room for the blocks that there are, or as many as may be.
  void make_room();
  Result<Vertex> vertex(std::uint32_t index);
  void take_into_account(const SpooledTriangle& triangle);
  /// Pairs open edges with others of nearly the same places.
  Status weld_open_edges();
  /// Finds the rule: by edges, by welded edges, then by faces that occur twice, of which spare ones are
  /// removed.
  Status settle_inside();
  /// Calls function(corners, index) for all triangles, then for those without an area.
  template <typename Function>
  Status for_each_face(const Function& function) const;

  std::string folder_;
  std::uint64_t memory_bytes_, most_blocks_;
  std::optional<io::ScratchList<Vertex>> vertices_;
  std::vector<Block> blocks_;               // each for the blocks of which the number has its remainder
  std::unique_ptr<std::byte[]> of_blocks_;  // pages are not touched before they are filled
  std::optional<io::ScratchList<SpooledTriangle>> triangles_;
  io::ScratchList<EdgeSums::Corners> slivers_;  // triangles without an area: they may be what closes the mesh
  InsideJudge judge_;
  MeshSummary summary_;
  double area_ = 0;
  Vec3d color_;  // times area
};

/// A mesh file in a spool that is finished; an error where there is no triangle in it.
Result<std::unique_ptr<MeshSpool>> spool_mesh(const std::string& path, const std::string& folder,
                                              std::uint64_t memory_bytes, const io::MeshProgress& progress);

}  // namespace gvx::mesh
