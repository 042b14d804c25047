#include "gvx/engine/engine.h"

#include <utility>

namespace gvx::engine {

Result<std::unique_ptr<Engine>> Engine::create(const exec::Device& device,
                                               std::shared_ptr<const produce::Producer> producer,
                                               const EngineOptions& options) {
  GVX_ASSIGN(auto cache, Cache::create(device, {options.memory_bytes, options.pools, options.warn}));
  GVX_ASSIGN(auto volume, cache->open(std::move(producer)));
  const ViewerOptions viewer{options.one_ray_at_a_time, options.prefetch, options.adapt_levels,
                             options.proxy};
  return std::unique_ptr<Engine>(new Engine(std::move(cache), std::move(volume), viewer));
}

}  // namespace gvx::engine
