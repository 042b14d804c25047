#include "gvx/tree/node_pool.h"

#include <algorithm>

#include "gvx/exec/for_each.h"

namespace gvx::tree {
namespace {

/// The second of the two steps of the GPU Pro text, 3.6.2: every node looks whether what it points to was
/// flagged.
struct ClearRecycled {
  exec::BufferView<ChildWord> child;
  exec::BufferView<ContentWord> content;
  const std::uint32_t* tile_recycled;
  const std::uint32_t* brick_recycled;
  GVX_HD void operator()(std::size_t i) const {
    if (tile_recycled[child[i].children().value] != 0) child[i].bits &= ~kPointerMask;
    if (content[i].kind() == ContentKind::brick && brick_recycled[content[i].brick().value] != 0)
      content[i] = {};
  }
};

}  // namespace

NodePool::NodePool(const exec::Device& device, std::uint32_t n, std::uint32_t tiles, std::uint32_t channels)
    : device_(device),
      tiles_(tiles),
      nodes_per_tile_(n * n * n),
      channels_(channels),
      child_(device, std::size_t(tiles) * nodes_per_tile_),
      content_(device, child_.size()),
      range_(device, child_.size() * channels),
      tile_recycled_(device, tiles) {
  GVX_CHECK(child_.size() <= kPointerMask);
}

void NodePool::reset_node(NodeIndex node, const NodeInfo& info) {
  const bool constant = info.ranges.constant();
  child_.view()[node.value] = {info.terminal || constant ? kTerminalBit : 0};
  content_.view()[node.value] = constant ? ContentWord::constant() : ContentWord{};
  for (std::uint32_t c = 0; c < channels_; ++c) {
    range_.view()[std::size_t(c) * nodes() + node.value] = info.ranges.channel[c];
  }
}

void NodePool::set_children(NodeIndex node, TileIndex children) {
  ChildWord& word = child_.view()[node.value];
  GVX_CHECK(!word.terminal());
  word.bits = (word.bits & ~kPointerMask) | children.value;
}

void NodePool::set_content(NodeIndex node, ContentWord content) {
  content_.view()[node.value] = content;
}

void NodePool::set_constant(NodeIndex node, const ChannelRanges& values) {
  reset_node(node, {values.at_minimum(), true});
}

void NodePool::clear_pointers(std::span<const std::uint32_t> recycled_tiles,
                              std::span<const std::uint32_t> recycled_bricks, std::uint32_t bricks) {
  if (recycled_tiles.empty() && recycled_bricks.empty()) return;
  if (brick_recycled_.size() < bricks) brick_recycled_ = exec::Buffer<std::uint32_t>(device_, bricks);
  for (const std::uint32_t tile : recycled_tiles) tile_recycled_.view()[tile] = 1;
  for (const std::uint32_t brick : recycled_bricks) brick_recycled_.view()[brick] = 1;
  exec::for_each(
      device_, "clear_recycled", nodes(),
      ClearRecycled{child_.view(), content_.view(), tile_recycled_.view().data, brick_recycled_.view().data});
  for (const std::uint32_t tile : recycled_tiles) tile_recycled_.view()[tile] = 0;
  for (const std::uint32_t brick : recycled_bricks) brick_recycled_.view()[brick] = 0;
}

}  // namespace gvx::tree
