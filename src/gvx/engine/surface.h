/// \file
/// Surface: one surface in a cache: its producer, and those of its elements that are in memory. However many
/// viewers look at it and objects show it, it is there once.
#pragma once

#include <memory>
#include <utility>

#include "gvx/engine/surface_residency.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/production.h"

namespace gvx::engine {

class Surface {
 public:
  /// `id` is the producer's name in the production, which forgets it at the end.
  Surface(std::shared_ptr<const produce::Producer> producer, std::shared_ptr<produce::Production> production,
          produce::TreeId id)
      : producer_(std::move(producer)), production_(std::move(production)), id_(id), residency_(id) {}
  ~Surface() { production_->remove(id_); }
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;

  const std::shared_ptr<const produce::Producer>& producer() const { return producer_; }
  const tree::TreeDescription& tree() const { return producer_->description(); }
  produce::TreeId id() const { return id_; }
  SurfaceResidency& residency() { return residency_; }
  const SurfaceResidency& residency() const { return residency_; }

 private:
  std::shared_ptr<const produce::Producer> producer_;
  std::shared_ptr<produce::Production> production_;
  produce::TreeId id_;
  SurfaceResidency residency_;
};

}  // namespace gvx::engine
