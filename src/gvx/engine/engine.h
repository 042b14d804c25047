/// \file
/// Engine: renders a volume that may be larger than memory: one Viewer with a Cache of its own. The volume is
/// a tree of nodes; each node has a brick, a small cube of voxels. Rays march through the bricks in memory,
/// and mark those that they lack. A producer reads or computes the marked bricks. They take the place of
/// bricks that were not used for the longest time. Then the rays go on. An exact picture ends when no ray
/// lacks anything, a frame with a budget when its time is over.
///
/// Whoever has several viewers or volumes makes a Cache and Viewers (cache.h, viewer.h).
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/engine/cache.h"
#include "gvx/engine/viewer.h"
#include "gvx/exec/device.h"
#include "gvx/produce/producer.h"

namespace gvx::engine {

/// How an engine works; the defaults suit most programs.
struct EngineOptions {
  std::uint64_t memory_bytes = 512ull << 20;  ///< for bricks, nodes, and what producers keep
  std::optional<PoolSizes> pools;             ///< in place of memory_bytes; for tests of tiny pools
  /// As ViewerOptions has them.
  bool one_ray_at_a_time = false;
  bool prefetch = true;
  bool adapt_levels = true;
  std::shared_ptr<const scene::Proxy> proxy = {};
  /// As CacheOptions has it.
  std::function<void(const std::string&)> warn = {};
};

/// For one thread at a time.
class Engine {
 public:
  /// An error if the program has no kernels for this device and type of voxels, or memory_bytes is too
  /// little.
  static Result<std::unique_ptr<Engine>> create(const exec::Device& device,
                                                std::shared_ptr<const produce::Producer> producer,
                                                const EngineOptions& options);

  /// What these do is said in viewer.h.
  Status look(const render::View& view) { return viewer_.look(view, volume_); }
  Status render_exact(const RayProgress& progress = {}) { return viewer_.render_exact(progress); }
  Status render_for(std::chrono::nanoseconds budget) { return viewer_.render_for(budget); }
  bool converged() const { return viewer_.converged(); }
  render::Picture picture() const { return viewer_.picture(); }
  Status picture(const render::PictureTarget& target) { return viewer_.picture(target); }
  Statistics statistics() const { return viewer_.statistics(); }

  const produce::TreeDescription& tree() const { return volume_->tree(); }
  /// For tests.
  const Residency& residency() const { return volume_->residency(); }

 private:
  Engine(std::shared_ptr<Cache> cache, std::shared_ptr<Volume> volume, const ViewerOptions& options)
      : volume_(std::move(volume)), viewer_(std::move(cache), options) {}

  std::shared_ptr<Volume> volume_;
  Viewer viewer_;
};

}  // namespace gvx::engine
