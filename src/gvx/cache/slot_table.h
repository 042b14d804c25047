/// \file
/// SlotTable: what is in the slots of a pool, by name, and which slot to give away first. Slots are numbers;
/// the memory behind them is the pool's.
///
///     usage stamps, written by rays -> order_by_use() -> the oldest slots -> take() -> put()
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include "gvx/cache/usage_list.h"
#include "gvx/core/macros.h"

namespace gvx::cache {

/// Which slots may be given away.
enum class Eviction {
  unused,  ///< only what is not in use: a preview's rays come back to what they touched
  any      ///< the oldest, used or not: exact rays have passed the bricks that they used
};

/// Slots that were given away, and those of them that held something, to which others may still point.
struct TakenSlots {
  std::vector<std::uint32_t> slots, recycled;
};

template <typename Key, typename Hash = std::hash<Key>>
class SlotTable {
 public:
  /// Slots 0 to `slots`-1; the first `reserved` of them are never given away, and have no name.
  SlotTable(const exec::Device& device, std::uint32_t slots, std::uint32_t reserved = 0)
      : usage_(device, slots, reserved), unused_(slots - reserved) {}

  /// What kernels stamp.
  UsageView usage() { return usage_.view(); }
  std::uint32_t slots() const { return usage_.slots(); }
  /// Slots that hold something.
  std::size_t size() const { return slot_of_.size(); }

  std::optional<std::uint32_t> find(const Key& key) const {
    const auto found = slot_of_.find(key);
    return found == slot_of_.end() ? std::nullopt : std::optional(found->second);
  }
  bool contains(const Key& key) const { return slot_of_.contains(key); }
  bool occupied(std::uint32_t slot) const { return slot < owners_.size() && owners_[slot].occupied; }
  /// What an occupied slot holds.
  const Key& key(std::uint32_t slot) const { return owners_[slot].key; }

  /// After a pass: the slots that it stamped become the newest. Those that pass `in_use_since` or a later one
  /// stamped are in use.
  void order_by_use(std::uint32_t pass, std::uint32_t in_use_since) {
    usage_.order_by_use(pass);
    unused_ = usage_.unused_since(in_use_since);
  }
  /// How many slots take() would give.
  std::uint32_t room(Eviction eviction) const {
    return eviction == Eviction::any ? usage_.givable() : unused_;
  }

  /// The oldest slots, as many as there is room for, but no more than `wanted`. They are empty now: put()
  /// something in each, or it is the newest for nothing.
  TakenSlots take(std::size_t wanted, Eviction eviction) {
    const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(wanted, room(eviction)));
    TakenSlots taken{usage_.take_oldest(count), {}};
    unused_ -= std::min(unused_, count);
    empty(taken);
    return taken;
  }
  /// The `count` oldest slots hold nothing any more and are not to be given away, until restore().
  TakenSlots withhold(std::uint32_t count) {
    TakenSlots taken{usage_.withhold(count), {}};
    unused_ -= std::min(unused_, count);
    empty(taken);
    return taken;
  }
  void restore(std::uint32_t count) {
    usage_.restore(count);
    unused_ += count;
  }
  std::uint32_t withheld() const { return usage_.withheld(); }
  std::uint32_t oldest_pass() const { return usage_.oldest_pass(); }

  /// Names what is in an empty slot; nothing else may have the name.
  void put(std::uint32_t slot, const Key& key) {
    GVX_CHECK(!occupied(slot) && !contains(key));
    if (slot >= owners_.size()) owners_.resize(slot + 1);
    owners_[slot] = {key, true};
    slot_of_[key] = slot;
  }

  /// Checks names, slots and order against each other; aborts where they disagree. For tests.
  void check_invariants() const {
    std::size_t occupied = 0;
    for (const Owner& owner : owners_) occupied += owner.occupied ? 1 : 0;
    GVX_CHECK(occupied == slot_of_.size());
    for (const auto& [key, slot] : slot_of_) GVX_CHECK(owners_[slot].occupied && owners_[slot].key == key);
    std::vector<bool> there(slots());
    for (const std::uint32_t slot : usage_.order()) {
      GVX_CHECK(!there[slot]);
      there[slot] = true;
    }
  }

 private:
  struct Owner {
    Key key{};
    bool occupied = false;
  };

  /// Lists those of the slots that held something, and forgets what.
  void empty(TakenSlots& taken) {
    for (const std::uint32_t slot : taken.slots) {
      if (!occupied(slot)) continue;
      Owner& owner = owners_[slot];
      slot_of_.erase(owner.key);
      owner.occupied = false;
      taken.recycled.push_back(slot);
    }
  }

  UsageList usage_;
  std::vector<Owner> owners_;  // of each slot that ever held something
  std::unordered_map<Key, std::uint32_t, Hash> slot_of_;
  std::uint32_t unused_;  // at the front of the order
};

}  // namespace gvx::cache
