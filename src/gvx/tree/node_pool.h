/// \file
/// NodePool owns the resident part of an N3-tree. The N^3 children of a node stand together in a tile, the
/// unit of its cache. Tile 0 holds the root, as its first node, and is never recycled. Nodes may share
/// children and bricks: whoever recycles a slot has every pointer to it cleared, wherever it stands.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gvx/core/index.h"
#include "gvx/core/node_key.h"
#include "gvx/core/voxel.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"
#include "gvx/tree/node_words.h"

namespace gvx::tree {

/// What kernels descend.
struct NodePoolView {
  const ChildWord* child = nullptr;
  const ContentWord* content = nullptr;
  const ValueRange* range = nullptr;  ///< of channel c of a node: range[c * range_stride + node]
  std::uint32_t range_stride = 0;

  GVX_HD ValueRange range_of(NodeIndex node, std::uint32_t channel) const {
    return range[std::size_t(channel) * range_stride + node.value];
  }
};

/// What is known of a node before any of its voxels is.
struct NodeInfo {
  /// Of everything below it and of a rim of n voxels around (store/format.h). All of a single value: the node
  /// is constant.
  ChannelRanges ranges;
  bool terminal = false;  ///< there is nothing finer
};

class NodePool {
 public:
  /// A pool of `tiles` tiles of n^3 nodes, the root's among them, that know the ranges of `channels`.
  NodePool(const exec::Device& device, std::uint32_t n, std::uint32_t tiles, std::uint32_t channels);

  NodePoolView view() const {
    return {child_.view().data, content_.view().data, range_.view().data, nodes()};
  }
  std::uint32_t tiles() const { return tiles_; }
  std::uint64_t bytes() const { return std::uint64_t{tiles_} * nodes_per_tile_ * node_bytes(channels_); }
  /// Of a tile of n^3 nodes that know the ranges of `channels`.
  static std::uint64_t tile_bytes(std::uint32_t n, std::uint32_t channels) {
    return std::uint64_t{n} * n * n * node_bytes(channels);
  }
  std::uint32_t nodes() const { return tiles() * nodes_per_tile_; }
  std::uint32_t nodes_per_tile() const { return nodes_per_tile_; }
  static NodeIndex root() { return NodeIndex(0); }

  ChildWord child(NodeIndex node) const { return child_.view()[node.value]; }
  ContentWord content(NodeIndex node) const { return content_.view()[node.value]; }
  ChannelRanges ranges(NodeIndex node) const {
    ChannelRanges ranges;
    for (std::uint32_t c = 0; c < channels_; ++c) ranges.channel[c] = view().range_of(node, c);
    return ranges;
  }
  TileIndex tile_of(NodeIndex node) const { return TileIndex(node.value / nodes_per_tile_); }
  NodeIndex node_of(TileIndex tile, std::uint32_t child_index) const {
    return NodeIndex(tile.value * nodes_per_tile_ + child_index);
  }

  /// Writes a node afresh: no children, no brick; constant where its range is.
  void reset_node(NodeIndex node, const NodeInfo& info);
  void set_children(NodeIndex node, TileIndex children);
  void set_content(NodeIndex node, ContentWord content);
  /// Makes a node constant after all: its brick, once made, was of one value a channel.
  void set_constant(NodeIndex node, const ChannelRanges& values);

  /// Clears every pointer to these tiles and bricks; `bricks` is the size of the brick pool.
  void clear_pointers(std::span<const std::uint32_t> recycled_tiles,
                      std::span<const std::uint32_t> recycled_bricks, std::uint32_t bricks);

 private:
  static std::uint64_t node_bytes(std::uint32_t channels) {
    return sizeof(ChildWord) + sizeof(ContentWord) + channels * sizeof(ValueRange);
  }

  exec::Device device_;
  std::uint32_t tiles_, nodes_per_tile_, channels_;
  exec::Buffer<ChildWord> child_;
  exec::Buffer<ContentWord> content_;
  exec::Buffer<ValueRange> range_;
  exec::Buffer<std::uint32_t> tile_recycled_, brick_recycled_;
};

}  // namespace gvx::tree
