/// \file
/// Look: how one viewer sees one tree: which of its resident nodes, and which cells of its resident bricks,
/// have nothing to see in them. Trees are shared, looks are not.
#pragma once

#include <cstdint>
#include <optional>

#include "gvx/brick/cell_masks.h"
#include "gvx/core/index.h"
#include "gvx/core/voxel.h"
#include "gvx/exec/device.h"
#include "gvx/scene/visibility.h"
#include "gvx/tree/hidden_nodes.h"
#include "gvx/tree/node_pool.h"

namespace gvx::engine {

/// A residency tells its looks what has changed (Residency::attach).
class Look {
 public:
  /// For pools of this many tiles and bricks. Until see(), all can be seen.
  Look(const exec::Device& device, std::uint32_t tiles, std::uint32_t bricks)
      : hidden_(device, tiles), cells_(device, bricks) {}

  /// What kernels look up.
  tree::HiddenNodesView hidden() const { return hidden_.view(); }
  brick::CellMaskView cells() { return cells_.view(); }

  /// Can nothing be seen of a node of these ranges?
  bool hides(const ChannelRanges& ranges) const;

  /// Sees by this from now on; its tables must live until the next call. The nodes of the pool are to be
  /// classified anew.
  void see(const scene::Visibility& visibility);
  /// The same tables at other addresses: nothing is classified anew.
  void move_tables(const scene::Visibility& visibility) { visibility_ = visibility; }

  /// A tile's nodes are others, or seen by another function.
  void classify_tile(const tree::NodePool& nodes, TileIndex tile);
  /// A node's ranges are others.
  void classify_node(const tree::NodePool& nodes, NodeIndex node);
  /// A slot holds another brick.
  void forget_brick(BrickIndex slot) { cells_.forget(slot); }

 private:
  std::optional<scene::Visibility> visibility_;
  tree::HiddenNodes hidden_;
  brick::CellMasks cells_;
};

}  // namespace gvx::engine
