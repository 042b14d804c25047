/// \file
/// LeafTable: the nodes that the rays of a tile have come to, so that each is walked to once, and the rays
/// that wait before their bricks. Private to this room; for one thread.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "gvx/core/result.h"
#include "gvx/render/tile_rays.h"
#include "gvx/render/tree_walk.h"

namespace gvx::render {

/// Of a node of some level: its place along each axis, in nodes of that level.
struct Cell {
  std::int32_t x = 0, y = 0, z = 0;

  bool operator==(const Cell&) const = default;
};

/// A node at which walks of steps of one level end.
struct Leaf {
  Place place;
  int level = 0;       ///< of the steps that led here
  int step_level = 0;  ///< of those that are taken: coarser in a preview's stand-in
  bool blended = false;
  std::uint32_t lack = 0;  ///< levels that a preview's stand-in is coarser than wanted
  Cell low, high;          ///< its cells, of `level`: low <= cell < high

  std::uint64_t waiting[TileRays::kMost / 64] = {};        ///< a bit for each ray that waits
  bool active = false;                                     ///< one does
  float nearest = std::numeric_limits<float>::infinity();  ///< t of the nearest of them

  bool holds(int l, bool b, Cell cell) const {
    return level == l && blended == b && low.x <= cell.x && cell.x < high.x && low.y <= cell.y &&
           cell.y < high.y && low.z <= cell.z && cell.z < high.z;
  }
};

class LeafTable {
 public:
  static constexpr std::uint32_t kMost = NodeFaces::kMost;
  static constexpr std::uint32_t kNone = ~0u;

  void clear() {
    size_ = 0;
    active_size_ = 0;
    forget_slots();
  }

  bool has_room_for(std::uint32_t more) const { return size_ + more <= kMost; }
  const Leaf& operator[](std::uint32_t index) const { return leaves_[index]; }
  const NodeFaces& faces() const { return faces_; }

  /// The leaf that holds this cell of steps of `level`, or kNone. `n` is the tree's.
  std::uint32_t find(int level, bool blended, Cell cell, std::int32_t n) {
    if (last_ < size_ && leaves_[last_].holds(level, blended, cell)) return last_;
    const std::uint32_t there = find_slot(level, blended, level, cell);
    if (slots_[there].age == age_) return last_ = slots_[there].leaf;
    // A coarser node, perhaps; found once, it is found by this cell too, while there are slots to spare.
    Cell ancestor = cell;
    for (int l = level - 1; l >= 0; --l) {
      ancestor = {ancestor.x / n, ancestor.y / n, ancestor.z / n};
      const Slot& slot = slots_[find_slot(level, blended, l, ancestor)];
      if (slot.age == age_ && leaves_[slot.leaf].place.level == l) {
        if (slots_used_ < kSlots / 2) use_slot(there, level, blended, level, cell, slot.leaf);
        return last_ = slot.leaf;
      }
    }
    return kNone;
  }

  /// Adds a leaf that is not there yet; where there is room.
  std::uint32_t add(const Leaf& leaf, double stride, bool zoned) {
    GVX_CHECK(size_ < kMost);
    const std::uint32_t index = size_++;
    leaves_[index] = leaf;
    remember(index);
    const Place& place = leaf.place;
    for (int axis = 0; axis < 3; ++axis) {
      faces_.face[axis][index] = place.cell[axis] / place.across;
      faces_.face[axis][kMost + index] = (place.cell[axis] + 1) / place.across;
    }
    // Steps within a stretch are counted in floats.
    constexpr double kMostInBrick = 1 << 22;
    faces_.stride[index] = stride;
    faces_.most_steps[index] = place.kind == Place::brick ? kMostInBrick : 1e15;
    faces_.zoned[index] = zoned ? 1 : 0;
    return last_ = index;
  }

  /// A ray waits before the leaf's brick, at distance t.
  void wait(std::uint32_t index, std::uint32_t ray, double t) {
    Leaf& leaf = leaves_[index];
    if (!leaf.active) active_[active_size_++] = index;
    leaf.active = true;
    leaf.waiting[ray / 64] |= std::uint64_t(1) << ray % 64;
    leaf.nearest = std::fmin(leaf.nearest, static_cast<float>(t));
  }

  /// The leaf before which the nearest ray waits, or kNone.
  std::uint32_t nearest() const {
    std::uint32_t nearest = kNone;
    float t = std::numeric_limits<float>::infinity();
    for (std::uint32_t i = 0; i < active_size_; ++i) {
      const Leaf& leaf = leaves_[active_[i]];
      if (nearest == kNone || leaf.nearest < t) {
        nearest = active_[i];
        t = leaf.nearest;
      }
    }
    return nearest;
  }

  /// Moves the rays that wait before a leaf to a list, in their order.
  void release(std::uint32_t index, RayList& list) {
    Leaf& leaf = leaves_[index];
    list.size = 0;
    for (std::uint32_t word = 0; word < TileRays::kMost / 64; ++word) {
      list.push_bits(64 * word, leaf.waiting[word]);
      leaf.waiting[word] = 0;
    }
    leaf.active = false;
    leaf.nearest = std::numeric_limits<float>::infinity();
    for (std::uint32_t i = 0; i < active_size_; ++i) {
      if (active_[i] == index) {
        active_[i] = active_[--active_size_];
        return;
      }
    }
  }

  /// Forgets the leaves before which no ray waits.
  void forget_idle() {
    const std::uint32_t before = size_;
    size_ = 0;
    active_size_ = 0;
    forget_slots();
    for (std::uint32_t i = 0; i < before; ++i) {
      if (!leaves_[i].active) continue;
      const std::uint32_t index = size_++;
      leaves_[index] = leaves_[i];
      for (int axis = 0; axis < 3; ++axis) {
        faces_.face[axis][index] = faces_.face[axis][i];
        faces_.face[axis][kMost + index] = faces_.face[axis][kMost + i];
      }
      faces_.stride[index] = faces_.stride[i];
      faces_.most_steps[index] = faces_.most_steps[i];
      faces_.zoned[index] = faces_.zoned[i];
      remember(index);
      active_[active_size_++] = index;
    }
  }

 private:
  static constexpr std::uint32_t kSlots = 4 * kMost;

  /// Where a cell of steps of `level`, or an ancestor of `node_level` of theirs, finds its leaf.
  struct Slot {
    Cell cell;
    std::uint16_t steps = 0;  // level, ancestor's level and blending of the steps
    std::uint16_t leaf = 0;
    std::uint32_t age = 0;  // of another than the table's: not used
  };

  static std::uint32_t steps_of(int level, bool blended, int node_level) {
    return static_cast<std::uint32_t>(level << 7 | node_level << 1 | (blended ? 1 : 0));
  }
  std::uint32_t find_slot(int level, bool blended, int node_level, Cell cell) const {
    const std::uint32_t steps = steps_of(level, blended, node_level);
    // Odd multipliers spread neighbours (Teschner et al., "Optimized spatial hashing", 2003).
    const std::uint32_t hash = static_cast<std::uint32_t>(cell.x) * 73856093u ^
                               static_cast<std::uint32_t>(cell.y) * 19349663u ^
                               static_cast<std::uint32_t>(cell.z) * 83492791u ^ steps * 2654435761u;
    std::uint32_t i = (hash ^ hash >> 15) % kSlots;
    while (slots_[i].age == age_ && !(slots_[i].cell == cell && slots_[i].steps == steps))
      i = (i + 1) % kSlots;
    return i;
  }
  void use_slot(std::uint32_t i, int level, bool blended, int node_level, Cell cell, std::uint32_t leaf) {
    slots_[i] = {cell, static_cast<std::uint16_t>(steps_of(level, blended, node_level)),
                 static_cast<std::uint16_t>(leaf), age_};
    ++slots_used_;
  }
  void forget_slots() {
    if (++age_ == 0) {
      slots_.fill({});
      age_ = 1;
    }
    slots_used_ = 0;
    last_ = 0;
  }
  void remember(std::uint32_t index) {
    const Leaf& leaf = leaves_[index];
    const Vec3d at = leaf.place.cell;
    const Cell cell{static_cast<std::int32_t>(at.x), static_cast<std::int32_t>(at.y),
                    static_cast<std::int32_t>(at.z)};
    const std::uint32_t i = find_slot(leaf.level, leaf.blended, leaf.place.level, cell);
    if (slots_[i].age != age_) use_slot(i, leaf.level, leaf.blended, leaf.place.level, cell, index);
  }

  std::uint32_t size_ = 0, active_size_ = 0, slots_used_ = 0;
  std::uint32_t last_ = 0;  // that was found
  std::uint32_t age_ = 1;
  std::array<Slot, kSlots> slots_{};
  std::array<Leaf, kMost> leaves_;
  std::array<std::uint32_t, TileRays::kMost> active_{};  // leaves before which rays wait
  NodeFaces faces_;
};

}  // namespace gvx::render
