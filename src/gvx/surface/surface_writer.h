/// \file
/// SurfaceWriter: writes the bricks of a surface into a surface store (surface_format.h). The file is called
/// PATH.partial until it is whole, so a file called PATH always is.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/store/appended_file.h"
#include "gvx/store/codec.h"
#include "gvx/surface/surface_format.h"
#include "gvx/surface/surface_pyramid.h"

namespace gvx::surface {

/// What a store says of its surface as a whole.
struct SurfaceInfo {
  std::uint32_t levels = 1;     ///< depth of the tree, the root included
  Affine3 cells_to_world;       ///< from cells of the finest level
  Box3d bounds;                 ///< of the surface, in cells of the finest level
  std::uint64_t triangles = 0;  ///< of the mesh
  UpAxis up = UpAxis::z;
  store::Codec codec = store::Codec::zstd;
  std::string source;  ///< the name of the file that it was built from

  /// Cells along an edge of the tree's cube.
  double cells() const { return std::ldexp(double(kCells), static_cast<int>(levels) - 1); }
};

/// Memory holds a page of nodes for each level, and where the others are: 16 bytes for 64 bricks.
class SurfaceWriter {
 public:
  static Result<std::unique_ptr<SurfaceWriter>> create(const std::string& path, std::uint32_t levels,
                                                       store::Codec codec);

  /// The next brick of a pyramid. An error where it cannot be written.
  Status add(const SurfacePyramid::Made& brick);

  /// Completes the store: then it has its name. `info` has as many levels as it was created with.
  Status finish(const SurfaceInfo& info);

  std::uint64_t bytes_written() const { return file_.end(); }
  std::uint64_t bricks() const;
  std::uint64_t samples() const { return samples_; }

 private:
  /// The cells that some of a surface is in, along each axis.
  struct Bounds {
    int low[3] = {kCells, kCells, kCells}, high[3] = {-1, -1, -1};

    void add(int axis, int first, int last);
  };
  struct Level {
    std::uint64_t nodes = 0;
    std::vector<Bounds> without_parent;  // of the last nodes
    std::vector<SurfaceNode> page;       // the last nodes, that are not written yet
    std::vector<store::BlockRef> pages;
  };

  SurfaceWriter(PartialFile file, std::uint32_t levels, store::Codec codec);
  Bounds bounds_of(const SurfacePyramid::Made& brick);
  Status add_pieces(SurfaceNode& node, const SurfacePyramid::Made& brick);
  Status add_piece(SurfaceNode& node, Piece piece, store::BlockLayout layout, std::span<const std::byte> raw);
  Status end_page(Level& level);

  store::AppendedFile file_;
  store::Codec codec_;
  std::vector<Level> levels_;
  std::uint64_t samples_ = 0;
  std::vector<std::byte> compressed_;
};

}  // namespace gvx::surface
