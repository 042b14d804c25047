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

/// A node at which walks of steps of one level end.
struct Leaf {
  Place place;
  int level = 0;       ///< of the steps that led here
  int step_level = 0;  ///< of those that are taken: coarser in a preview's stand-in
  bool blended = false;
  std::uint32_t lack = 0;  ///< levels that a preview's stand-in is coarser than wanted
  Vec3d low, high;         ///< its cells, of `level`: low <= cell < high

  std::int32_t first_waiting = -1;  ///< of its rays; LeafTable links them
  std::uint32_t waiting = 0;
  float nearest = std::numeric_limits<float>::infinity();  ///< t of the nearest of them

  bool holds(int l, bool b, Vec3d cell) const {
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
    slots_.fill(0);
    recent_.fill(0);
  }

  bool has_room_for(std::uint32_t more) const { return size_ + more <= kMost; }
  const Leaf& operator[](std::uint32_t index) const { return leaves_[index]; }
  const NodeFaces& faces() const { return faces_; }

  /// The leaf that holds this cell of steps of `level`, or kNone. `n` is the tree's.
  std::uint32_t find(int level, bool blended, Vec3d cell, int n) {
    for (std::uint32_t& index : recent_) {
      if (index < size_ && leaves_[index].holds(level, blended, cell)) return index;
    }
    Vec3d ancestor = cell;
    for (int l = level; l >= 0; --l) {
      for (std::uint32_t slot = slot_of(level, blended, l, ancestor);; slot = (slot + 1) % kSlots) {
        if (slots_[slot] == 0) break;
        const std::uint32_t index = slots_[slot] - 1u;
        const Leaf& leaf = leaves_[index];
        if (leaf.place.level == l && leaf.holds(level, blended, cell)) return remember(index);
      }
      for (int axis = 0; axis < 3; ++axis) ancestor[axis] = std::floor(ancestor[axis] / n);
    }
    return kNone;
  }

  /// Adds a leaf that is not there yet; where there is room.
  std::uint32_t add(const Leaf& leaf, double stride, bool zoned) {
    GVX_CHECK(size_ < kMost);
    const std::uint32_t index = size_++;
    leaves_[index] = leaf;
    put_in_slot(index);
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
    return remember(index);
  }

  /// A ray waits before the leaf's brick, at distance t.
  void wait(std::uint32_t index, std::int32_t ray, double t) {
    Leaf& leaf = leaves_[index];
    if (leaf.first_waiting < 0) active_[active_size_++] = index;
    next_waiting_[static_cast<std::size_t>(ray)] = leaf.first_waiting;
    leaf.first_waiting = ray;
    ++leaf.waiting;
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

  /// Moves the rays that wait before a leaf to a list.
  void release(std::uint32_t index, RayList& list) {
    Leaf& leaf = leaves_[index];
    list.size = 0;
    for (std::int32_t ray = leaf.first_waiting; ray >= 0;
         ray = next_waiting_[static_cast<std::size_t>(ray)]) {
      list.ray[list.size++] = ray;
    }
    leaf.first_waiting = -1;
    leaf.waiting = 0;
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
    slots_.fill(0);
    for (std::uint32_t i = 0; i < before; ++i) {
      if (leaves_[i].first_waiting < 0) continue;
      const std::uint32_t index = size_++;
      leaves_[index] = leaves_[i];
      for (int axis = 0; axis < 3; ++axis) {
        faces_.face[axis][index] = faces_.face[axis][i];
        faces_.face[axis][kMost + index] = faces_.face[axis][kMost + i];
      }
      faces_.stride[index] = faces_.stride[i];
      faces_.most_steps[index] = faces_.most_steps[i];
      faces_.zoned[index] = faces_.zoned[i];
      put_in_slot(index);
      active_[active_size_++] = index;
    }
  }

 private:
  static constexpr std::uint32_t kSlots = 4 * kMost;

  static std::uint32_t slot_of(int level, bool blended, int node_level, Vec3d cell) {
    // Odd multipliers spread neighbours (Teschner et al., "Optimized spatial hashing", 2003).
    std::uint64_t hash = static_cast<std::uint64_t>(cell.x) * 73856093u;
    hash ^= static_cast<std::uint64_t>(cell.y) * 19349663u;
    hash ^= static_cast<std::uint64_t>(cell.z) * 83492791u;
    hash ^= static_cast<std::uint64_t>(level * 64 + node_level * 2 + (blended ? 1 : 0)) * 2654435761u;
    return static_cast<std::uint32_t>((hash ^ hash >> 21) % kSlots);
  }
  void put_in_slot(std::uint32_t index) {
    const Leaf& leaf = leaves_[index];
    std::uint32_t slot = slot_of(leaf.level, leaf.blended, leaf.place.level, leaf.place.cell);
    while (slots_[slot] != 0) slot = (slot + 1) % kSlots;
    slots_[slot] = static_cast<std::uint16_t>(index + 1);
  }
  std::uint32_t remember(std::uint32_t index) {
    recent_[oldest_++ % recent_.size()] = index;
    return index;
  }

  std::uint32_t size_ = 0, active_size_ = 0, oldest_ = 0;
  std::array<std::uint32_t, 4> recent_{};
  std::array<std::uint16_t, kSlots> slots_{};  // index + 1, or 0
  std::array<Leaf, kMost> leaves_;
  std::array<std::uint32_t, TileRays::kMost> active_{};  // leaves before which rays wait
  std::array<std::int32_t, TileRays::kMost> next_waiting_{};
  NodeFaces faces_;
};

}  // namespace gvx::render
