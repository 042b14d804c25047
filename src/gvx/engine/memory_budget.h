/// \file
/// MemoryBudget: shares a number of bytes out among the bricks of several volumes. Each volume's pool could
/// fill all of it; what a pool may not use now is withheld from it, and goes to where bricks are wanted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "gvx/engine/volume.h"

namespace gvx::engine {

class MemoryBudget {
 public:
  explicit MemoryBudget(std::uint64_t bytes) : bytes_(bytes) {}

  /// A volume comes: it gets what is left of the bytes.
  void add(Volume* volume);
  void remove(const Volume* volume);

  /// Makes room for `wanted` bricks of a volume, as far as possible: at the cost of the volume's own oldest
  /// bricks, of bytes that nobody has, and then of the oldest bricks of others; those in use only by force.
  void make_room(Volume& volume, std::size_t wanted, Eviction eviction);

 private:
  std::uint64_t left() const;
  Volume* with_oldest(const Volume& but, Eviction eviction) const;

  std::uint64_t bytes_;
  std::vector<Volume*> volumes_;
};

}  // namespace gvx::engine
