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

namespace gvx::produce {

/// Display red, green and blue.
using Rgb8 = std::array<std::uint8_t, 3>;

/// What meshes without colours have.
inline constexpr Rgb8 kPlainColor = {204, 204, 204};

/// A triangle that needs no vertices elsewhere.
struct SpooledTriangle {
  std::array<Vec3f, 3> corners;
  std::array<Rgb8, 3> colors;
};

struct MeshSummary {
  std::uint64_t vertices = 0;                       ///< whether a triangle has them or not
  std::uint64_t triangles = 0;                      ///< that cover anything
  std::uint64_t dropped = 0;                        ///< the others, and those of vertices that are not there
  Box3d bounds{Vec3d(INFINITY), Vec3d(-INFINITY)};  ///< of the triangles
  bool colors = false;
  Vec3f mean_color;  ///< of the surface
  /// Is every edge of two triangles, or of an even number, so that there is an inside? Edges between equal
  /// places are one, whatever vertices they are of.
  bool closed = false;
};

/// One thread fills it, then finishes it. Vertices wait on disk, too, and as many as fit half of the memory
/// are read again in blocks: where triangles jump about among more of them than that, each corner is a read.
class MeshSpool final : public io::MeshSink {
 public:
  enum class Keep { triangles, summary_only };

  /// Its scratch files stand in `folder`.
  static Result<std::unique_ptr<MeshSpool>> create(const std::string& folder, std::uint64_t memory_bytes,
                                                   Keep keep = Keep::triangles);

  Status add_vertices(std::span<const Vec3f> places, std::span<const Vec3f> colors) override;
  Status add_triangles(std::span<const io::Triangle> triangles) override;

  /// To be called after the last triangle.
  Status finish();

  /// What it all is, once it is finished.
  const MeshSummary& summary() const { return summary_; }

  /// In the file's order, once it is finished; none where only the summary is kept.
  const io::ScratchList<SpooledTriangle>& triangles() const { return triangles_; }

  const std::string& folder() const { return folder_; }

 private:
  struct Vertex {
    Vec3f place;
    Rgb8 color;
  };

  /// Vertices that were read together; of a list that still grew, perhaps fewer than a block holds.
  struct Block {
    std::uint64_t number = UINT64_MAX;
    std::size_t vertices = 0;
  };

  MeshSpool(std::string folder, std::uint64_t memory_bytes, Keep keep, io::ScratchList<Vertex> vertices,
            io::ScratchList<SpooledTriangle> triangles);

  /// Makes room for the blocks that there are, or as many as may be.
  void make_room();
  Result<Vertex> vertex(std::uint32_t index);
  void take_into_account(const SpooledTriangle& triangle);

  std::string folder_;
  Keep keep_;
  std::uint64_t most_blocks_;
  std::optional<io::ScratchList<Vertex>> vertices_;
  std::vector<Block> blocks_;               // each for the blocks of which the number has its remainder
  std::unique_ptr<std::byte[]> of_blocks_;  // pages are not touched before they are filled
  io::ScratchList<SpooledTriangle> triangles_;
  MeshSummary summary_;
  double area_ = 0;
  Vec3d color_;                         // times area
  std::array<std::uint64_t, 2> odd_{};  // 0 where all edges are there an even number of times
};

/// A mesh file in a spool that is finished; an error where there is no triangle in it.
Result<std::unique_ptr<MeshSpool>> spool_mesh(const std::string& path, const std::string& folder,
                                              std::uint64_t memory_bytes, MeshSpool::Keep keep,
                                              const io::MeshProgress& progress);

}  // namespace gvx::produce
