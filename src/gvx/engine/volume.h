/// \file
/// Volume: one volume in a cache: its producer, and the part of its tree that is in memory. However many
/// viewers look at it and objects show it, it is there once.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "gvx/engine/residency.h"
#include "gvx/exec/device.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/production.h"

namespace gvx::engine {

class Volume {
 public:
  /// `id` is the producer's name in the production, which forgets it at the end.
  Volume(const exec::Device& device, std::shared_ptr<const produce::Producer> producer,
         std::shared_ptr<produce::Production> production, produce::TreeId id, PoolSizes sizes)
      : producer_(std::move(producer)),
        production_(std::move(production)),
        id_(id),
        residency_(device, *producer_, id, sizes) {}
  ~Volume() { production_->remove(id_); }
  Volume(const Volume&) = delete;
  Volume& operator=(const Volume&) = delete;

  const std::shared_ptr<const produce::Producer>& producer() const { return producer_; }
  const tree::TreeDescription& tree() const { return producer_->description(); }
  produce::TreeId id() const { return id_; }
  Residency& residency() { return residency_; }
  const Residency& residency() const { return residency_; }

  /// Bricks whose values were beyond their nodes' bounds, since the volume was opened.
  std::uint64_t broken_bounds() const { return broken_bounds_; }
  /// Adds those of a commit; are they the first?
  bool count_broken_bounds(const CommitCounts& counts) {
    const bool first = broken_bounds_ == 0 && counts.first_broken.has_value();
    broken_bounds_ += counts.broken_bounds;
    return first;
  }

 private:
  std::shared_ptr<const produce::Producer> producer_;
  std::shared_ptr<produce::Production> production_;
  produce::TreeId id_;
  Residency residency_;
  std::uint64_t broken_bounds_ = 0;
};

}  // namespace gvx::engine
