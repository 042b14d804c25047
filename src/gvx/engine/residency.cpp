#include "gvx/engine/residency.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <unordered_set>
#include <utility>

namespace gvx::engine {

using produce::ElementKey;
using produce::ElementKind;
using produce::FinishedElement;

Result<PoolSizes> PoolSizes::fitting(std::uint64_t memory_bytes, const produce::TreeDescription& tree) {
  constexpr std::uint64_t kFewestTiles = 8192, kMostTiles = 1u << 22, kMostBricks = 1u << 28;
  const std::uint64_t fit = memory_bytes / tree.brick_bytes();
  if (fit < 2) {
    return Error{"memory: " + std::to_string(memory_bytes) + " bytes do not hold two bricks of " +
                 std::to_string(tree.brick_bytes()) + " bytes"};
  }
  const std::uint64_t there_are = tree.bricks > 0 ? tree.bricks + 1 : kMostBricks;
  const std::uint64_t bricks = std::min({fit, there_are, kMostBricks});
  // Every resident brick hangs on a path of tiles; most of a path is shared, and transparent nodes take room
  // too. They take an eighth of the memory at most, as far as that is enough for some paths.
  constexpr std::uint64_t kPart = 8, kSomePaths = 1024;
  const std::uint64_t tile_bytes = tree::NodePool::tile_bytes(tree.n, tree.format.channels());
  const std::uint64_t most = std::max(memory_bytes / kPart / tile_bytes, kSomePaths);
  const std::uint64_t tiles = std::min({std::clamp(bricks, kFewestTiles, kMostTiles), there_are + 64, most});
  return PoolSizes{static_cast<std::uint32_t>(tiles), static_cast<std::uint32_t>(bricks)};
}

std::string BrokenBounds::message() const {
  std::ostringstream text;
  text << "producer: the brick of node (" << key.x << ", " << key.y << ", " << key.z << ") of level "
       << key.level << " holds values from " << found.minimum << " to " << found.maximum
       << ", but its bounds are " << promised.minimum << " to " << promised.maximum;
  if (channel > 0) text << " (channel " << channel << ")";
  text << "; parts of pictures may be missing until the producer's bounds are wider";
  return text.str();
}

Residency::Residency(const exec::Device& device, const produce::Producer& producer, produce::TreeId tree,
                     PoolSizes sizes)
    : producer_(producer),
      tree_(tree),
      nodes_(device, producer.description().n, sizes.tiles, producer.description().format.channels()),
      bricks_(device, producer.description().brick_bytes(), sizes.bricks),
      marks_(device, nodes_.nodes()),
      tile_slots_(device, sizes.tiles, 1),
      brick_slots_(device, sizes.bricks) {}

Status Residency::plant_root() {
  const NodeKey root;
  tree::NodeInfo info;
  GVX_TRY(producer_.describe(std::span(&root, 1), std::span(&info, 1)));
  nodes_.reset_node(tree::NodePool::root(), info);
  for (Look* look : looks_) look->classify_node(nodes_, tree::NodePool::root());
  return {};
}

std::optional<ElementKey> Residency::ask_for_root() {
  const NodeIndex root = tree::NodePool::root();
  if (nodes_.content(root).kind() != tree::ContentKind::none) return std::nullopt;
  const ElementKey element{tree_, NodeKey{}, ElementKind::brick};
  askers_[element] = {UINT32_MAX, {root}};  // kept until it comes
  return element;
}

void Residency::attach(Look& look) {
  looks_.push_back(&look);
  classify_all(look);
}

void Residency::detach(Look& look) {
  std::erase(looks_, &look);
}

void Residency::set_visibility(Look& look, const scene::Visibility& visibility) {
  look.see(visibility);
  classify_all(look);
}

void Residency::classify_all(Look& look) const {
  look.classify_node(nodes_, tree::NodePool::root());
  for (std::uint32_t tile = 1; tile < nodes_.tiles(); ++tile) {
    if (tile_slots_.occupied(tile)) look.classify_tile(nodes_, TileIndex(tile));
  }
}

NodeKey Residency::key_of(NodeIndex node) const {
  const TileIndex tile = nodes_.tile_of(node);
  if (tile.value == 0) return NodeKey{};
  const int index = static_cast<int>(node.value - nodes_.node_of(tile, 0).value);
  return producer_.canonical(
      child(tile_slots_.key(tile.value), static_cast<int>(producer_.description().n), index));
}

void Residency::link(NodeIndex node, const ElementKey& element) {
  if (element.kind == ElementKind::brick) {
    if (const auto slot = brick_slots_.find(element.node)) {
      nodes_.set_content(node, tree::ContentWord::of_brick(BrickIndex(*slot)));
    }
  } else if (const auto tile = tile_slots_.find(element.node)) {
    nodes_.set_children(node, TileIndex(*tile));
  }
}

bool Residency::is_gone(NodeIndex node) const {
  const TileIndex tile = nodes_.tile_of(node);
  return tile.value != 0 && !tile_slots_.occupied(tile.value);
}

std::vector<Lacking> Residency::collect(std::uint32_t pass, std::uint32_t in_use_since) {
  tile_slots_.order_by_use(pass, in_use_since);
  brick_slots_.order_by_use(pass, in_use_since);
  // Rays that still march ask again in each pass.
  std::erase_if(askers_, [&](const auto& asked) { return asked.second.pass < in_use_since; });
  std::vector<Lacking> lacking;
  const auto requests = marks_.collect();
  requested_ = requests.size();
  std::unordered_set<ElementKey, produce::ElementKeyHash> listed;
  for (const cache::Request& request : requests) {
    const NodeKey key = key_of(request.node);
    for (const auto& [bit, kind] : {std::pair(cache::kNeedsBrick, ElementKind::brick),
                                    std::pair(cache::kNeedsChildren, ElementKind::children)}) {
      if ((request.kinds & bit) == 0) continue;
      const ElementKey element{tree_, key, kind};
      const bool resident =
          kind == ElementKind::brick ? brick_slots_.contains(key) : tile_slots_.contains(key);
      if (resident) {
        link(request.node, element);
        continue;
      }
      Askers& askers = askers_[element];
      if (listed.insert(element).second) {
        lacking.push_back({element, request.priority});
        askers.nodes.clear();
      }
      askers.pass = pass;
      askers.nodes.push_back(request.node);
    }
  }
  std::stable_sort(lacking.begin(), lacking.end(), more_urgent);
  return lacking;
}

void Residency::fill_tile(TileIndex tile, const FinishedElement& made) {
  const produce::Element& children = made.element.value();
  tile_slots_.put(tile.value, made.key.node);
  for (std::uint32_t i = 0; i < nodes_.nodes_per_tile(); ++i) {
    const NodeIndex node = nodes_.node_of(tile, i);
    const tree::NodeInfo& info = children.children[i];
    nodes_.reset_node(node, info);
    if (info.ranges.constant()) continue;
    link(node, {tree_, children.child_keys[i], ElementKind::brick});
    if (!info.terminal) link(node, {tree_, children.child_keys[i], ElementKind::children});
  }
  for (Look* look : looks_) look->classify_tile(nodes_, tile);
}

std::optional<BrokenBounds> Residency::broken_bounds(NodeIndex node, const FinishedElement& made) const {
  const std::optional<ChannelRanges>& found_ranges = made.element.value().found;
  if (!found_ranges) return std::nullopt;
  const ChannelRanges promised = nodes_.ranges(node);
  for (std::uint32_t c = 0; c < producer_.description().format.channels(); ++c) {
    const ValueRange bounds = promised.channel[c], found = found_ranges->channel[c];
    if (found.minimum < bounds.minimum || found.maximum > bounds.maximum) {
      return BrokenBounds{made.key.node, c, bounds, found};
    }
  }
  return std::nullopt;
}

void Residency::withhold_bricks(std::uint32_t count) {
  const cache::TakenSlots taken = brick_slots_.withhold(count);
  nodes_.clear_pointers({}, taken.recycled, bricks_.slots());
  bricks_.release(taken.recycled, [&](std::uint32_t slot) { return !brick_slots_.occupied(slot); });
}

CommitCounts Residency::commit(std::vector<FinishedElement> made, Eviction eviction) {
  CommitCounts counts;
  std::vector<const FinishedElement*> tiles, bricks;
  std::unordered_set<ElementKey, produce::ElementKeyHash> seen;
  for (const FinishedElement& element : made) {
    if (!element.element.ok() || !seen.insert(element.key).second) continue;
    if (element.key.kind == ElementKind::children) {
      if (!tile_slots_.contains(element.key.node)) tiles.push_back(&element);
    } else if (!element.element.value().constant && !brick_slots_.contains(element.key.node)) {
      bricks.push_back(&element);
    }
  }
  const cache::TakenSlots for_tiles = tile_slots_.take(tiles.size(), eviction);
  const cache::TakenSlots for_bricks = brick_slots_.take(bricks.size(), eviction);
  counts.bricks_evicted = for_bricks.recycled.size();
  nodes_.clear_pointers(for_tiles.recycled, for_bricks.recycled, bricks_.slots());

  for (std::size_t i = 0; i < for_bricks.slots.size(); ++i) {
    const std::uint32_t slot = for_bricks.slots[i];
    bricks_.write(BrickIndex(slot), bricks[i]->element.value().voxels);
    for (Look* look : looks_) look->forget_brick(BrickIndex(slot));
    brick_slots_.put(slot, bricks[i]->key.node);
  }
  for (std::size_t i = 0; i < for_tiles.slots.size(); ++i)
    fill_tile(TileIndex(for_tiles.slots[i]), *tiles[i]);
  for (const FinishedElement& element : made) {
    if (element.element.ok()) link_askers(element, counts);
  }
  return counts;
}

void Residency::link_askers(const FinishedElement& made, CommitCounts& counts) {
  const auto askers = askers_.find(made.key);
  if (askers == askers_.end()) return;
  const std::optional<ChannelRanges>& constant = made.element.value().constant;
  bool compared = false;
  for (const NodeIndex node : askers->second.nodes) {
    // The tile that the asker stood in may have been given away since.
    if (is_gone(node) || key_of(node) != made.key.node) continue;
    if (!std::exchange(compared, true)) {
      if (const auto broken = broken_bounds(node, made)) {
        ++counts.broken_bounds;
        if (!counts.first_broken) counts.first_broken = broken;
      }
    }
    if (constant) {
      nodes_.set_constant(node, *constant);
      for (Look* look : looks_) look->classify_node(nodes_, node);
    } else {
      link(node, made.key);
    }
  }
  askers_.erase(askers);
}

void Residency::check_invariants() const {
  tile_slots_.check_invariants();
  brick_slots_.check_invariants();
  for (std::uint32_t i = 0; i < nodes_.nodes(); ++i) {
    const NodeIndex node(i);
    if (nodes_.tile_of(node).value == 0 ? i != 0 : is_gone(node)) continue;
    const tree::ChildWord child_word = nodes_.child(node);
    const tree::ContentWord content = nodes_.content(node);
    const NodeKey key = key_of(node);
    if (child_word.has_children()) {
      GVX_CHECK(!child_word.terminal());
      GVX_CHECK(tile_slots_.find(key) == child_word.children().value);
    }
    if (content.kind() == tree::ContentKind::brick) {
      GVX_CHECK(brick_slots_.find(key) == content.brick().value);
    }
    if (content.kind() == tree::ContentKind::constant) GVX_CHECK(nodes_.ranges(node).constant());
    const TileIndex tile = nodes_.tile_of(node);
    for (const Look* look : looks_) {
      GVX_CHECK(look->hidden().at(tile.value, i - nodes_.node_of(tile, 0).value) ==
                look->hides(nodes_.ranges(node)));
    }
    tree::NodeInfo info;
    GVX_CHECK(producer_.describe(std::span(&key, 1), std::span(&info, 1)).ok());
    GVX_CHECK(nodes_.ranges(node) == info.ranges || nodes_.ranges(node).constant());
    GVX_CHECK(content.kind() != tree::ContentKind::constant || info.ranges.constant() || info.terminal);
  }
}

}  // namespace gvx::engine
