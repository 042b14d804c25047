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

namespace gvx::surface {

/// The order in which bricks are made: each node's after all below it, the children of a node in theirs
/// (Morton 1966). Of keys of one level.
bool before_in_tree(const NodeKey& a, const NodeKey& b);

class SurfacePyramid {
 public:
  /// A brick that is whole.
  struct Made {
    NodeKey key;
    const SampledCells& samples;
    std::uint8_t children;  ///< a bit for each of its eight that is there
  };
  /// Takes one brick after the other, children before their parents.
  using Take = std::function<Status(const Made&)>;

  SurfacePyramid(std::uint32_t finest_level, Take take);

  /// The next brick of the finest level, in the tree's order, each once; one without cells is passed over.
  /// Ends with the first error of what takes the bricks.
  Status push(const NodeKey& key, SampledCells samples);
  /// After the last one.
  Status finish();

 private:
  /// A brick that more may come to.
  struct Open {
    NodeKey key;
    SampledCells samples;
    std::uint8_t children = 0;
  };

  Status close(std::uint32_t level);

  std::uint32_t finest_;
  Take take_;
  std::vector<std::optional<Open>> open_;  // one a level
  std::optional<NodeKey> last_;
};

}  // namespace gvx::surface
