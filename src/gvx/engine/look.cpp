#include "gvx/engine/look.h"

namespace gvx::engine {

bool Look::hides(const ChannelRanges& ranges) const {
  if (!visibility_) return false;
  bool any_values = false;
  for (std::uint32_t c = 0; c < visibility_->channels; ++c) {
    any_values = any_values || ranges.channel[c].minimum <= ranges.channel[c].maximum;
  }
  // What has no data is not seen, but of a mean it must be known how much of its ray that is.
  if (!any_values && visibility_->mode != scene::Mode::mean) return true;
  return visibility_->hides(ranges);
}

void Look::see(const scene::Visibility& visibility) {
  visibility_ = visibility;
  cells_.forget_all();
}

void Look::classify_tile(const tree::NodePool& nodes, TileIndex tile) {
  std::uint32_t hidden = 0;
  for (std::uint32_t i = 0; i < nodes.nodes_per_tile(); ++i) {
    if (hides(nodes.ranges(nodes.node_of(tile, i)))) hidden |= 1u << i;
  }
  hidden_.set_tile(tile, hidden);
}

void Look::classify_node(const tree::NodePool& nodes, NodeIndex node) {
  const TileIndex tile = nodes.tile_of(node);
  hidden_.set(tile, node.value - nodes.node_of(tile, 0).value, hides(nodes.ranges(node)));
}

}  // namespace gvx::engine
