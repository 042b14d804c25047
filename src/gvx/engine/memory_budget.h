/// \file
/// MemoryBudget: shares a number of bytes out among several volumes and surfaces: for the nodes of volumes'
/// trees, for what producers keep, for bricks, and for elements of surfaces. Each volume's pool of bricks
/// could fill all of it; what a pool may not use now is withheld from it, and goes to where bricks are
/// wanted.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "gvx/engine/surface.h"
#include "gvx/engine/volume.h"

namespace gvx::engine {

class MemoryBudget {
 public:
  explicit MemoryBudget(std::uint64_t bytes) : bytes_(bytes) {}

  /// A volume comes: it gets what is left of the bytes. Its producer is told what it may keep.
  void add(Volume* volume);
  void remove(const Volume* volume);
  void add(Surface* surface) { surfaces_.push_back(surface); }
  void remove(const Surface* surface) { std::erase(surfaces_, surface); }

  /// Makes room for `wanted` bricks of a volume, as far as possible: of bytes that nobody has, and of those
  /// of other volumes' bricks that were not used for longer than the volume's own oldest; those in use only
  /// by force.
  void make_room(Volume& volume, std::size_t wanted, Eviction eviction);

  /// Makes room for so many bytes of surfaces: what was used longest ago goes, of surfaces and volumes.
  /// Returns whether there is so much.
  bool make_room(std::uint64_t wanted_bytes, Eviction eviction);

 private:
  /// A volume, and the bytes that are counted for its nodes and its producer.
  struct Share {
    Volume* volume;
    std::uint64_t of_nodes;
    std::uint64_t producer_wants;
    std::uint64_t of_producer = 0;
  };

  void share_out(std::uint64_t most_growth);
  std::uint64_t bytes_used() const;
  std::uint64_t bytes_left() const { return bytes_ - std::min(bytes_, bytes_used()); }
  Volume* with_oldest(const Volume* but, Eviction eviction) const;
  Surface* surface_with_oldest(Eviction eviction) const;

  std::uint64_t bytes_;
  std::vector<Share> shares_;
  std::vector<Surface*> surfaces_;
};

}  // namespace gvx::engine
