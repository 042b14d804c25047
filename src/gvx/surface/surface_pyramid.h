/// \file
/// SurfacePyramid: from the finest bricks of a surface to those of all levels. It holds one brick a level, so
/// a surface may be of any size.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "gvx/core/node_key.h"
#include "gvx/core/result.h"
#include "gvx/surface/sampled_cells.h"
#include "gvx/surface/triangle_list.h"

namespace gvx::surface {

/// The order in which bricks are made: each node's after all below it, the children of a node in theirs
/// (Morton 1966). Of keys of one level.
bool before_in_tree(const NodeKey& a, const NodeKey& b);

/// A brick is *unresolved* where samples would say no more than its triangles do, and take more: there are
/// more than four for each triangle, or so few that most of a grid would be empty (Reichl and others 2012,
/// section 3.1, compare the triangles' sizes with a cell's, and speak of the fill rate).
struct Resolution {
  static constexpr std::uint64_t kMostSamplesOfTriangle = 4;
  static constexpr std::uint64_t kFewestSamples = 64, kMostTrianglesOfSample = 2;

  static bool unresolved(std::uint64_t samples, std::uint64_t triangles) {
    if (triangles == 0) return false;
    return samples > kMostSamplesOfTriangle * triangles ||
           (samples < kFewestSamples && triangles <= kMostTrianglesOfSample * samples);
  }
};

class SurfacePyramid {
 public:
  /// A brick that is whole.
  struct Made {
    NodeKey key;
    const SampledCells& samples;
    std::uint8_t children;  ///< a bit for each of its eight that is there
    /// Are samples of no use? So are those of all bricks below it, whose triangles it refers to.
    bool unresolved = false;
    const TriangleList* triangles = nullptr;  ///< of a brick of the finest level
  };
  /// Takes one brick after the other, children before their parents.
  using Take = std::function<Status(const Made&)>;

  SurfacePyramid(std::uint32_t finest_level, Take take);

  /// The next brick of the finest level, in the tree's order, each once; one without cells is passed over.
  /// Ends with the first error of what takes the bricks.
  Status push(const NodeKey& key, SampledCells samples, TriangleList triangles = {});
  /// After the last one.
  Status finish();

 private:
  /// A brick that more may come to.
  struct Open {
    NodeKey key;
    SampledCells samples;
    std::uint8_t children = 0;
    TriangleList triangles = {};
    std::uint64_t triangles_below = 0;
    bool resolved_below = false;
  };

  Status close(std::uint32_t level);

  std::uint32_t finest_;
  Take take_;
  std::vector<std::optional<Open>> open_;  // one a level
  std::optional<NodeKey> last_;
};

}  // namespace gvx::surface
