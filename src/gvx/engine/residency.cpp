#include "gvx/engine/residency.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <unordered_set>
#include <utility>

namespace gvx::engine {

using produce::Job;
using produce::JobKind;
using produce::Produced;

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
  // too.
  const std::uint64_t tiles = std::min(std::clamp(bricks, kFewestTiles, kMostTiles), there_are + 64);
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

Residency::Residency(const exec::Device& device, const produce::Producer& producer, PoolSizes sizes)
    : producer_(producer),
      nodes_(device, producer.description().n, sizes.tiles, producer.description().format.channels()),
      bricks_(device, producer.description().brick_bytes(), sizes.bricks),
      marks_(device, nodes_.nodes()),
      tile_occupied_(sizes.tiles),
      brick_owner_(sizes.bricks) {}

Status Residency::plant_root() {
  const NodeKey root;
  tree::NodeInfo info;
  GVX_TRY(producer_.describe(std::span(&root, 1), std::span(&info, 1)));
  nodes_.reset_node(tree::NodePool::root(), info, is_transparent(info.ranges));
  unused_tiles_ = nodes_.usage().givable();
  unused_bricks_ = bricks_.usage().givable();
  return {};
}

Result<CommitCounts> Residency::plant_root_brick() {
  const NodeIndex root = tree::NodePool::root();
  if (nodes_.content(root).kind() != tree::ContentKind::none || nodes_.child(root).transparent()) {
    return CommitCounts{};
  }
  const Job job{NodeKey{}, JobKind::brick};
  askers_[job] = {root};
  GVX_ASSIGN(CommitCounts counts, commit(produce::make(producer_, std::span(&job, 1)), Eviction::any));
  GVX_CHECK(counts.committed == 1);
  return counts;
}

void Residency::set_visibility(const scene::Visibility& visibility, bool another) {
  visibility_ = visibility;
  if (!another) return;
  bricks_.cell_masks().forget_all();
  nodes_.reclassify([&](const ChannelRanges& ranges) { return is_transparent(ranges); });
}

bool Residency::is_transparent(const ChannelRanges& ranges) const {
  if (!visibility_) return false;
  bool any_values = false;
  for (std::uint32_t c = 0; c < visibility_->channels; ++c) {
    any_values = any_values || ranges.channel[c].minimum <= ranges.channel[c].maximum;
  }
  // What has no data is not seen, but of a mean it must be known how much of its ray that is.
  if (!any_values && visibility_->mode != scene::Mode::mean) return true;
  return visibility_->hides(ranges);
}

NodeKey Residency::key_of(NodeIndex node) const {
  const TileIndex tile = nodes_.tile_of(node);
  if (tile.value == 0) return NodeKey{};
  const int index = static_cast<int>(node.value - nodes_.node_of(tile, 0).value);
  return producer_.canonical(
      child(nodes_.tile_parent(tile), static_cast<int>(producer_.description().n), index));
}

void Residency::link(NodeIndex node, const Job& job) {
  if (job.kind == JobKind::brick) {
    if (const auto found = brick_of_.find(job.key); found != brick_of_.end()) {
      nodes_.set_content(node, tree::ContentWord::of_brick(found->second));
    }
  } else if (const auto found = tile_of_.find(job.key); found != tile_of_.end()) {
    nodes_.set_children(node, found->second);
  }
}

std::vector<Job> Residency::collect(std::uint32_t pass) {
  unused_tiles_ = nodes_.usage().order_by_use(pass);
  unused_bricks_ = bricks_.usage().order_by_use(pass);
  askers_.clear();
  struct Urgent {
    Job job;
    std::uint32_t priority;
  };
  std::vector<Urgent> urgent;
  const auto requests = marks_.collect();
  requested_ = requests.size();
  for (const cache::Request& request : requests) {
    const NodeKey key = key_of(request.node);
    for (const auto& [bit, kind] : {std::pair(cache::kNeedsBrick, JobKind::brick),
                                    std::pair(cache::kNeedsChildren, JobKind::children)}) {
      if ((request.kinds & bit) == 0) continue;
      const Job job{key, kind};
      const bool resident = kind == JobKind::brick ? brick_of_.contains(key) : tile_of_.contains(key);
      if (resident) {
        link(request.node, job);
        continue;
      }
      auto& askers = askers_[job];
      if (askers.empty()) urgent.push_back({job, request.priority});
      askers.push_back(request.node);
    }
  }
  std::stable_sort(urgent.begin(), urgent.end(), [](const Urgent& a, const Urgent& b) {
    if (a.job.key.level != b.job.key.level) return a.job.key.level < b.job.key.level;
    return a.priority > b.priority;
  });
  std::vector<Job> jobs;
  jobs.reserve(urgent.size());
  for (const Urgent& u : urgent) jobs.push_back(u.job);
  return jobs;
}

std::size_t Residency::room_for_tiles(Eviction eviction) const {
  return eviction == Eviction::any ? nodes_.usage().givable() : unused_tiles_;
}

std::size_t Residency::room_for_bricks(Eviction eviction) const {
  return eviction == Eviction::any ? bricks_.usage().givable() : unused_bricks_;
}

bool Residency::limit_to_room(std::vector<Job>& jobs, Eviction eviction) const {
  std::size_t tiles = room_for_tiles(eviction), bricks = room_for_bricks(eviction);
  const auto kept = std::remove_if(jobs.begin(), jobs.end(), [&](const Job& job) {
    std::size_t& room = job.kind == JobKind::brick ? bricks : tiles;
    if (room == 0) return true;
    --room;
    return false;
  });
  const bool dropped = kept != jobs.end();
  jobs.erase(kept, jobs.end());
  return dropped;
}

std::vector<std::uint32_t> Residency::make_room_for_tiles(std::size_t wanted, Eviction eviction) {
  const auto count = static_cast<std::uint32_t>(std::min(wanted, room_for_tiles(eviction)));
  auto taken = nodes_.usage().take_oldest(count);
  unused_tiles_ -= std::min(unused_tiles_, count);
  for (const std::uint32_t tile : taken) {
    if (!tile_occupied_[tile]) continue;
    tile_of_.erase(nodes_.tile_parent(TileIndex(tile)));
    tile_occupied_[tile] = false;
    recycled_tiles_.push_back(tile);
  }
  return taken;
}

std::vector<std::uint32_t> Residency::make_room_for_bricks(std::size_t wanted, Eviction eviction) {
  const auto count = static_cast<std::uint32_t>(std::min(wanted, room_for_bricks(eviction)));
  auto taken = bricks_.usage().take_oldest(count);
  unused_bricks_ -= std::min(unused_bricks_, count);
  for (const std::uint32_t slot : taken) {
    BrickOwner& owner = brick_owner_[slot];
    if (!owner.occupied) continue;
    brick_of_.erase(owner.key);
    owner.occupied = false;
    recycled_bricks_.push_back(slot);
  }
  return taken;
}

void Residency::fill_tile(TileIndex tile, const Produced& made) {
  nodes_.set_tile_parent(tile, made.job.key);
  tile_occupied_[tile.value] = true;
  tile_of_[made.job.key] = tile;
  for (std::uint32_t i = 0; i < nodes_.nodes_per_tile(); ++i) {
    const NodeIndex node = nodes_.node_of(tile, i);
    const tree::NodeInfo& info = made.children[i];
    nodes_.reset_node(node, info, is_transparent(info.ranges));
    if (info.ranges.constant()) continue;
    link(node, {made.child_keys[i], JobKind::brick});
    if (!info.terminal) link(node, {made.child_keys[i], JobKind::children});
  }
}

std::optional<BrokenBounds> Residency::broken_bounds(NodeIndex node, const Produced& made) const {
  if (!made.found) return std::nullopt;
  const ChannelRanges promised = nodes_.ranges(node);
  for (std::uint32_t c = 0; c < producer_.description().format.channels(); ++c) {
    const ValueRange bounds = promised.channel[c], found = made.found->channel[c];
    if (found.minimum < bounds.minimum || found.maximum > bounds.maximum) {
      return BrokenBounds{made.job.key, c, bounds, found};
    }
  }
  return std::nullopt;
}

Result<CommitCounts> Residency::commit(std::vector<Produced> made, Eviction eviction) {
  CommitCounts counts;
  std::vector<const Produced*> tiles, bricks;
  Status failed;
  std::unordered_set<Job, produce::JobHash> seen;
  for (const Produced& p : made) {
    if (!seen.insert(p.job).second) continue;
    if (!p.status.ok()) {
      if (failed.ok()) failed = p.status;
      continue;
    }
    if (p.job.kind == JobKind::children) {
      if (!tile_of_.contains(p.job.key)) tiles.push_back(&p);
    } else if (!p.constant && !brick_of_.contains(p.job.key)) {
      bricks.push_back(&p);
    }
  }
  const auto tile_slots = make_room_for_tiles(tiles.size(), eviction);
  const auto brick_slots = make_room_for_bricks(bricks.size(), eviction);
  counts.bricks_evicted = recycled_bricks_.size();
  nodes_.clear_pointers(std::exchange(recycled_tiles_, {}), std::exchange(recycled_bricks_, {}),
                        bricks_.slots());
  counts.turned_away = tiles.size() - tile_slots.size() + bricks.size() - brick_slots.size();
  counts.committed = made.size() - counts.turned_away;

  for (std::size_t i = 0; i < brick_slots.size(); ++i) {
    const BrickIndex slot(brick_slots[i]);
    bricks_.write(slot, bricks[i]->voxels);
    brick_owner_[slot.value] = {bricks[i]->job.key, true};
    brick_of_[bricks[i]->job.key] = slot;
  }
  for (std::size_t i = 0; i < tile_slots.size(); ++i) fill_tile(TileIndex(tile_slots[i]), *tiles[i]);

  for (const Produced& p : made) {
    const auto askers = askers_.find(p.job);
    if (!p.status.ok() || askers == askers_.end()) continue;
    bool compared = false;
    for (const NodeIndex node : askers->second) {
      // The tile that the asker stood in may have been given away since.
      const TileIndex tile = nodes_.tile_of(node);
      if ((tile.value != 0 && !tile_occupied_[tile.value]) || key_of(node) != p.job.key) continue;
      if (!std::exchange(compared, true)) {
        if (auto broken = broken_bounds(node, p)) {
          ++counts.broken_bounds;
          if (!counts.first_broken) counts.first_broken = std::move(broken);
        }
      }
      if (p.constant) {
        nodes_.set_constant(node, *p.constant, is_transparent(*p.constant));
      } else {
        link(node, p.job);
      }
    }
  }
  GVX_TRY(failed);
  return counts;
}

void Residency::check_invariants() const {
  const auto is_permutation = [](std::span<const std::uint32_t> order, std::uint32_t first) {
    std::vector<std::uint32_t> sorted(order.begin(), order.end());
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      if (sorted[i] != first + i) return false;
    }
    return true;
  };
  GVX_CHECK(is_permutation(nodes_.usage().order(), 1));
  GVX_CHECK(is_permutation(bricks_.usage().order(), 0));
  for (const auto& [key, tile] : tile_of_) {
    GVX_CHECK(tile.value != 0 && tile_occupied_[tile.value] && nodes_.tile_parent(tile) == key);
  }
  for (const auto& [key, slot] : brick_of_) {
    GVX_CHECK(brick_owner_[slot.value].occupied && brick_owner_[slot.value].key == key);
  }
  GVX_CHECK(static_cast<std::size_t>(std::count(tile_occupied_.begin(), tile_occupied_.end(), true)) ==
            tile_of_.size());
  GVX_CHECK(static_cast<std::size_t>(std::count_if(brick_owner_.begin(), brick_owner_.end(),
                                                   [](const BrickOwner& o) { return o.occupied; })) ==
            brick_of_.size());
  for (std::uint32_t i = 0; i < nodes_.nodes(); ++i) {
    const NodeIndex node(i);
    const TileIndex tile = nodes_.tile_of(node);
    if (tile.value == 0 ? i != 0 : !tile_occupied_[tile.value]) continue;
    const tree::ChildWord child_word = nodes_.child(node);
    const tree::ContentWord content = nodes_.content(node);
    const NodeKey key = key_of(node);
    if (child_word.has_children()) {
      GVX_CHECK(!child_word.terminal());
      const auto found = tile_of_.find(key);
      GVX_CHECK(found != tile_of_.end() && found->second == child_word.children());
    }
    if (content.kind() == tree::ContentKind::brick) {
      const auto found = brick_of_.find(key);
      GVX_CHECK(found != brick_of_.end() && found->second == content.brick());
    }
    if (content.kind() == tree::ContentKind::constant) GVX_CHECK(nodes_.ranges(node).constant());
    GVX_CHECK(child_word.transparent() == is_transparent(nodes_.ranges(node)));
    tree::NodeInfo info;
    GVX_CHECK(producer_.describe(std::span(&key, 1), std::span(&info, 1)).ok());
    GVX_CHECK(nodes_.ranges(node) == info.ranges || nodes_.ranges(node).constant());
    GVX_CHECK(content.kind() != tree::ContentKind::constant || info.ranges.constant() || info.terminal);
  }
}

}  // namespace gvx::engine
