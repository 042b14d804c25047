/// \file
/// Residency: which part of the tree is in memory. It turns the marks of rays into jobs for producers, and
/// commits what producers made: finds room, clears every pointer to what had that room, and links the new.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "gvx/brick/brick_pool.h"
#include "gvx/cache/request_marks.h"
#include "gvx/cache/slot_table.h"
#include "gvx/core/result.h"
#include "gvx/engine/look.h"
#include "gvx/exec/device.h"
#include "gvx/produce/element.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/production.h"
#include "gvx/tree/node_pool.h"

namespace gvx::engine {

/// How much may be resident.
struct PoolSizes {
  std::uint32_t tiles = 0;
  std::uint32_t bricks = 0;

  /// Bricks for this much memory, but no more than the tree has, and tiles to match; an error where not even
  /// two fit.
  static Result<PoolSizes> fitting(std::uint64_t memory_bytes, const produce::TreeDescription& tree);
};

using cache::Eviction;

/// A brick that holds values beyond what its producer had promised of the node: what cannot be seen was told
/// by the promise, so parts of pictures may be missing.
struct BrokenBounds {
  NodeKey key;
  std::uint32_t channel = 0;
  ValueRange promised, found;  ///< stored values

  /// One line that says all this.
  std::string message() const;
};

/// What a commit did with what it was given.
struct CommitCounts {
  std::uint64_t bricks_evicted = 0;
  std::uint64_t broken_bounds = 0;                ///< bricks
  std::optional<BrokenBounds> first_broken = {};  ///< the first of them
};

/// An element that rays lack.
struct Lacking {
  produce::ElementKey element;
  std::uint32_t priority = 0;  ///< how much pictures would gain
};
/// Coarse levels come first: finer nodes are found below them.
inline bool more_urgent(const Lacking& a, const Lacking& b) {
  if (a.element.node.level != b.element.node.level) return a.element.node.level < b.element.node.level;
  return a.priority > b.priority;
}

/// Slots that may be given away.
struct Room {
  std::size_t tiles = 0, bricks = 0;

  /// Takes one for an element; false where none is left.
  bool take(produce::ElementKind kind) {
    std::size_t& left = kind == produce::ElementKind::brick ? bricks : tiles;
    if (left == 0) return false;
    --left;
    return true;
  }
};

class Residency {
 public:
  /// `tree` is the producer's name in what is asked for.
  Residency(const exec::Device& device, const produce::Producer& producer, produce::TreeId tree,
            PoolSizes sizes);

  /// Puts the root in place; once, before anything else.
  Status plant_root();

  /// The root's brick, if it is not there: to be made where a preview would have nothing else to show.
  std::optional<produce::ElementKey> ask_for_root();

  /// Keeps a look up to date from now on; it must live until it is detached.
  void attach(Look& look);
  void detach(Look& look);
  /// An attached look sees by this from now on: the resident nodes are classified anew. The tables must live
  /// until its next visibility.
  void set_visibility(Look& look, const scene::Visibility& visibility);

  const tree::NodePool& nodes() const { return nodes_; }
  const brick::BrickPool& bricks() const { return bricks_; }
  cache::UsageView tile_usage() { return tile_slots_.usage(); }
  cache::UsageView brick_usage() { return brick_slots_.usage(); }
  cache::RequestView requests() { return marks_.view(); }

  /// After a pass: orders both caches by use, and returns what its rays lack, the most urgent first, each
  /// once. What is resident under another name is linked at once. What pass `in_use_since` and later ones
  /// have touched is in use.
  std::vector<Lacking> collect(std::uint32_t pass, std::uint32_t in_use_since);

  /// For how much commit() would have room.
  Room room(Eviction eviction) const { return {tile_slots_.room(eviction), brick_slots_.room(eviction)}; }

  /// The `count` oldest bricks' slots are given up, and their memory with them, until they are restored.
  void withhold_bricks(std::uint32_t count);
  void restore_bricks(std::uint32_t count) { brick_slots_.restore(count); }
  std::uint32_t withheld_bricks() const { return brick_slots_.withheld(); }
  /// In which pass the oldest brick's slot was used last.
  std::uint32_t oldest_brick_pass() const { return brick_slots_.oldest_pass(); }

  /// Takes in what producers made; what failed is passed over.
  CommitCounts commit(std::vector<produce::FinishedElement> made, Eviction eviction);

  /// Requested nodes in the last collect().
  std::uint64_t requested() const { return requested_; }
  std::uint64_t resident_bricks() const { return brick_slots_.size(); }
  /// Slots that nothing is in.
  std::uint64_t free_bricks() const {
    return brick_slots_.slots() - brick_slots_.withheld() - resident_bricks();
  }
  std::uint64_t resident_nodes() const { return tile_slots_.size() * nodes_.nodes_per_tile() + 1; }

  /// Checks every pointer, map and list against each other; aborts where they disagree. For tests.
  void check_invariants() const;

 private:
  NodeKey key_of(NodeIndex node) const;
  void classify_all(Look& look) const;
  void link(NodeIndex node, const produce::ElementKey& job);
  /// Has the node's tile been given away?
  bool is_gone(NodeIndex node) const;
  void fill_tile(TileIndex tile, const produce::FinishedElement& made);
  void link_askers(const produce::FinishedElement& made, CommitCounts& counts);
  std::optional<BrokenBounds> broken_bounds(NodeIndex node, const produce::FinishedElement& made) const;

  const produce::Producer& producer_;
  produce::TreeId tree_;
  tree::NodePool nodes_;
  brick::BrickPool bricks_;
  cache::RequestMarks marks_;
  std::vector<Look*> looks_;
  cache::SlotTable<NodeKey, NodeKeyHash> tile_slots_;   // of nodes_, by the canonical parent
  cache::SlotTable<NodeKey, NodeKeyHash> brick_slots_;  // of bricks_, by the canonical node
  // Who asked for an element, and in which pass last; with shared sub-trees there may be many.
  struct Askers {
    std::uint32_t pass = 0;
    std::vector<NodeIndex> nodes;
  };
  std::unordered_map<produce::ElementKey, Askers, produce::ElementKeyHash> askers_;
  std::uint64_t requested_ = 0;
};

}  // namespace gvx::engine
