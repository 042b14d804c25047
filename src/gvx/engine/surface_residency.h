/// \file
/// SurfaceResidency: which elements of a surface are in memory: pages of nodes and pieces of bricks, each of
/// its own size. What was used longest ago goes first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <unordered_map>
#include <vector>

#include "gvx/cache/slot_table.h"
#include "gvx/produce/element.h"
#include "gvx/surface/draw/surface_cut.h"

namespace gvx::engine {

using cache::Eviction;

class SurfaceResidency final : public surface::ResidentSurface {
 public:
  /// `tree` is the producer's name in what is asked for.
  explicit SurfaceResidency(produce::TreeId tree) : tree_(tree) {}

  const surface::SurfaceNode* node(std::uint32_t level, std::uint32_t place) override;
  const std::byte* piece(std::uint32_t level, std::uint32_t place, surface::Piece piece) override;

  /// What is looked up from now on counts as used by this pass; what `in_use_since` and later passes have
  /// used is in use.
  void begin_pass(std::uint32_t pass, std::uint32_t in_use_since);

  /// How production calls what a picture lacks.
  produce::ElementKey key_of(const surface::LackingElement& lacking) const;

  bool contains(const produce::ElementKey& key) const { return elements_.contains(key); }
  /// Takes an element in; it counts as used by the last pass.
  void put(const produce::ElementKey& key, std::shared_ptr<const std::vector<std::byte>> bytes);

  /// What an element of so many bytes takes.
  static std::uint64_t bytes_of(std::uint64_t bytes) { return bytes + kOfEach; }
  std::uint64_t bytes() const { return bytes_; }
  std::size_t size() const { return elements_.size(); }
  /// In which pass what was used longest ago was used last; only of one that has elements.
  std::uint32_t oldest_pass() const { return elements_.at(order_.front()).pass; }
  /// Bytes that may go.
  std::uint64_t evictable(Eviction eviction) const;
  /// Can the oldest element go?
  bool may_evict(Eviction eviction) const;
  /// Lets it go.
  void evict_oldest();
  std::uint64_t evicted() const { return evicted_; }

 private:
  struct Kept {
    std::shared_ptr<const std::vector<std::byte>> bytes;
    std::uint32_t pass = 0;
    std::list<produce::ElementKey>::iterator place;
  };
  /// What is counted of an element beside its bytes: about what this class keeps for it.
  static constexpr std::uint64_t kOfEach = 256;

  const std::vector<std::byte>* use(const produce::ElementKey& key);

  produce::TreeId tree_;
  std::uint32_t pass_ = 0, in_use_since_ = 0;
  std::uint64_t bytes_ = 0, evicted_ = 0;
  std::list<produce::ElementKey> order_;  // the oldest first
  std::unordered_map<produce::ElementKey, Kept, produce::ElementKeyHash> elements_;
};

}  // namespace gvx::engine
