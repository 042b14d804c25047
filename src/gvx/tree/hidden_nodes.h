/// \file
/// HiddenNodes: which nodes of a NodePool somebody cannot see, a bit a node. Each viewer has its own.
///
///     word of a tile    bit i: its node i
#pragma once

#include <cstdint>

#include "gvx/core/index.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"

namespace gvx::tree {

/// What kernels look up.
struct HiddenNodesView {
  const std::uint32_t* words = nullptr;

  GVX_HD bool at(std::uint32_t tile, std::uint32_t index) const { return (words[tile] >> index & 1u) != 0; }
};

class HiddenNodes {
 public:
  /// Of a pool of this many tiles, whose nodes can all be seen.
  HiddenNodes(const exec::Device& device, std::uint32_t tiles) : words_(device, tiles) {}

  HiddenNodesView view() const { return {words_.view().data}; }
  bool at(TileIndex tile, std::uint32_t index) const { return view().at(tile.value, index); }
  /// Sets the bits of all nodes of a tile.
  void set_tile(TileIndex tile, std::uint32_t hidden) { words_.view()[tile.value] = hidden; }
  /// Sets the bit of one node.
  void set(TileIndex tile, std::uint32_t index, bool hidden) {
    std::uint32_t& word = words_.view()[tile.value];
    word = (word & ~(1u << index)) | (hidden ? 1u << index : 0u);
  }

 private:
  exec::Buffer<std::uint32_t> words_;
};

}  // namespace gvx::tree
