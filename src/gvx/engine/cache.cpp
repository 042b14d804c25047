#include "gvx/engine/cache.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "gvx/render/march_pass.h"
#include "gvx/render/vectors/instruction_set.h"

namespace gvx::engine {
namespace {

// Production threads beside a GPU, whose own host thread mostly waits.
constexpr int kCudaProducers = 8;

Status check(const tree::TreeDescription& tree) {
  if (tree.max_level >= kMaxLevels) {
    return Error{"volume: " + std::to_string(tree.max_level + 1) + " levels; the renderer knows " +
                 std::to_string(kMaxLevels)};
  }
  return check_placement(tree.tree_to_world);
}

Result<PoolSizes> sizes_for(const tree::TreeDescription& tree, const CacheOptions& options) {
  if (!options.pools) return PoolSizes::fitting(options.memory_bytes, tree);
  if (options.pools->tiles < tree.max_level + 2 || options.pools->bricks < 2) {
    return Error{"memory: the pools do not hold one path down the tree and two bricks"};
  }
  return *options.pools;
}

}  // namespace

Result<std::shared_ptr<Cache>> Cache::create(const exec::Device& device, const CacheOptions& options) {
  GVX_TRY(render::check_processor());
  return std::shared_ptr<Cache>(new Cache(device, options));
}

Cache::Cache(const exec::Device& device, const CacheOptions& options)
    : device_(device),
      options_(options),
      production_(std::make_shared<produce::Production>(
          device.kind() == exec::DeviceKind::cpu ? device.threads() : kCudaProducers)),
      budget_(options.pools ? UINT64_MAX : options.memory_bytes) {}

Cache::~Cache() = default;

Result<std::shared_ptr<Volume>> Cache::open(std::shared_ptr<const produce::Producer> producer) {
  if (producer == nullptr) return Error{"volume: no producer"};
  const exec::FairMutex::Turn turn = take_turn();
  for (const auto& volume : volumes_) {
    if (volume->producer() == producer) return volume;
  }
  forget_closed();
  const tree::TreeDescription& tree = producer->description();
  if (tree.surface) return Error{"volume: the producer makes a surface"};
  GVX_TRY(check(tree));
  GVX_TRY(render::check_kernels(device_, tree.format.type, tree.n, tree.m));
  GVX_ASSIGN(const PoolSizes sizes, sizes_for(tree, options_));
  const produce::TreeId id = production_->add(producer);
  auto volume = std::make_shared<Volume>(device_, std::move(producer), production_, id, sizes);
  GVX_TRY(volume->residency().plant_root());
  volumes_.push_back(volume);
  budget_.add(volume.get());
  return volume;
}

Result<std::shared_ptr<Surface>> Cache::open_surface(std::shared_ptr<const produce::Producer> producer) {
  if (producer == nullptr) return Error{"surface: no producer"};
  if (device_.kind() != exec::DeviceKind::cpu) {
    return Error{"a GPU renders no surfaces so far; use --device cpu"};
  }
  const exec::FairMutex::Turn turn = take_turn();
  for (const auto& surface : surfaces_) {
    if (surface->producer() == producer) return surface;
  }
  forget_closed();
  if (!producer->description().surface) return Error{"surface: the producer makes a volume"};
  GVX_TRY(check_placement(producer->description().tree_to_world));
  const produce::TreeId id = production_->add(producer);
  surfaces_.push_back(std::make_shared<Surface>(std::move(producer), production_, id));
  budget_.add(surfaces_.back().get());
  return surfaces_.back();
}

std::uint32_t Cache::begin_pass(Client& client) {
  client.pass = clock_.begin(client.walker);
  for (const auto& surface : surfaces_) surface->residency().begin_pass(client.pass, clock_.in_use_since());
  return client.pass;
}

void Cache::forget_closed() {
  std::erase_if(surfaces_, [&](const auto& surface) {
    if (surface.use_count() > 1) return false;
    budget_.remove(surface.get());
    return true;
  });
  std::erase_if(volumes_, [&](const auto& volume) {
    if (volume.use_count() > 1) return false;
    budget_.remove(volume.get());
    return true;
  });
}

Volume* Cache::volume_of(produce::TreeId tree) const {
  for (const auto& volume : volumes_) {
    if (volume->id() == tree) return volume.get();
  }
  return nullptr;
}

Surface* Cache::surface_of(produce::TreeId tree) const {
  for (const auto& surface : surfaces_) {
    if (surface->id() == tree) return surface.get();
  }
  return nullptr;
}

Cache::Client* Cache::add_client() {
  const exec::FairMutex::Turn turn = take_turn();
  clients_.push_back(std::make_unique<Client>());
  Client& client = *clients_.back();
  client.walker = clock_.add();
  client.producing = production_->add_client();
  return &client;
}

void Cache::remove_client(Client* client) {
  const exec::FairMutex::Turn turn = take_turn();
  clock_.remove(client->walker);
  production_->remove_client(client->producing);
  std::erase_if(clients_, [&](const auto& other) { return other.get() == client; });
  forget_closed();
}

void Cache::wait_until(const Client& client, std::chrono::steady_clock::time_point deadline) {
  production_->wait_until(client.producing, deadline);
}

std::vector<produce::ElementKey> Cache::collect(const Client& client, std::span<Volume* const> volumes,
                                                std::uint64_t& requests) {
  std::vector<Lacking> lacking;
  for (Volume* volume : volumes) {
    Residency& residency = volume->residency();
    const std::vector<Lacking> here = residency.collect(client.pass, clock_.in_use_since());
    lacking.insert(lacking.end(), here.begin(), here.end());
    requests += residency.requested();
  }
  if (volumes.size() > 1) std::stable_sort(lacking.begin(), lacking.end(), more_urgent);
  std::vector<produce::ElementKey> elements;
  elements.reserve(lacking.size());
  for (const Lacking& l : lacking) elements.push_back(l.element);
  return elements;
}

bool Cache::limit_to_room(std::vector<produce::ElementKey>& elements, Eviction eviction) {
  std::map<std::uint32_t, Room> rooms;
  for (const produce::ElementKey& element : elements) {
    rooms[element.tree.value].bricks += element.kind == produce::ElementKind::brick ? 1 : 0;
  }
  for (auto& [tree, room] : rooms)
    budget_.make_room(*volume_of(produce::TreeId(tree)), room.bricks, eviction);
  for (auto& [tree, room] : rooms) room = volume_of(produce::TreeId(tree))->residency().room(eviction);
  const auto kept = std::remove_if(elements.begin(), elements.end(), [&](const produce::ElementKey& element) {
    return !rooms[element.tree.value].take(element.kind);
  });
  const bool dropped = kept != elements.end();
  elements.erase(kept, elements.end());
  return dropped;
}

std::vector<produce::ElementKey> Cache::limit_to_room(const std::vector<SurfaceElement>& elements,
                                                      Eviction eviction) {
  std::vector<produce::ElementKey> kept;
  ElementSet seen;
  std::uint64_t bytes = 0;
  for (const SurfaceElement& element : elements) {
    if (!seen.insert(element.key).second) continue;
    if (!budget_.make_room(bytes + element.bytes, eviction)) break;
    bytes += element.bytes;
    kept.push_back(element.key);
  }
  return kept;
}

void Cache::want(Client& client, produce::Tier tier, const std::vector<produce::ElementKey>& elements) {
  ElementSet& wanted = tier == produce::Tier::visible ? client.visible : client.ahead;
  wanted = ElementSet(elements.begin(), elements.end());
  if (tier == produce::Tier::visible) {
    for (const produce::ElementKey& element : elements) client.ahead.erase(element);
  }
  production_->want(client.producing, tier, elements);
}

void Cache::commit(Client& client) {
  std::vector<produce::FinishedElement> made = std::exchange(others_, {});
  std::vector<produce::FinishedElement> finished = production_->take_finished();
  std::move(finished.begin(), finished.end(), std::back_inserter(made));
  const auto others = std::stable_partition(
      made.begin(), made.end(),
      [&](const produce::FinishedElement& element) { return client.visible.contains(element.key); });
  std::vector<produce::FinishedElement> of_others(std::make_move_iterator(others),
                                                  std::make_move_iterator(made.end()));
  made.erase(others, made.end());
  client.bricks_evicted += take_in(std::move(made), client.eviction);
  if (client.eviction == Eviction::any) {
    others_ = std::move(of_others);
  } else {
    client.bricks_evicted += take_in(std::move(of_others), Eviction::unused);
  }
}

std::uint64_t Cache::take_in(std::vector<produce::FinishedElement> made, Eviction eviction) {
  std::map<std::uint32_t, std::vector<produce::FinishedElement>> by_tree;
  for (produce::FinishedElement& element : made) {
    tell(element);
    if (element.element.ok()) by_tree[element.key.tree.value].push_back(std::move(element));
  }
  std::uint64_t evicted = 0;
  for (auto& [tree, elements] : by_tree) {
    if (Surface* const surface = surface_of(produce::TreeId(tree)); surface != nullptr) {
      for (const produce::FinishedElement& element : elements) {
        const auto& bytes = element.element.value().bytes;
        // What others asked for may find no room.
        const bool fits = budget_.make_room(SurfaceResidency::bytes_of(bytes->size()), eviction);
        if (fits) surface->residency().put(element.key, bytes);
      }
      continue;
    }
    Volume* volume = volume_of(produce::TreeId(tree));
    if (volume == nullptr) continue;  // it was closed meanwhile
    const CommitCounts counts = volume->residency().commit(std::move(elements), eviction);
    evicted += counts.bricks_evicted;
    if (volume->count_broken_bounds(counts) && options_.warn) options_.warn(counts.first_broken->message());
  }
  return evicted;
}

/// Tells those who want an element that it came, or why not. What nobody sees may fail: whoever comes to see
/// it will hear of it.
void Cache::tell(const produce::FinishedElement& made) {
  using Kind = produce::ElementKind;
  const bool is_brick = made.key.kind == Kind::brick || made.key.kind == Kind::surface_geometry ||
                        made.key.kind == Kind::surface_triangles;
  const std::uint64_t bricks = is_brick && made.element.ok() ? 1 : 0;
  for (const auto& client : clients_) {
    if (client->visible.erase(made.key) > 0) {
      client->bricks_made += bricks;
      client->came += made.element.ok() ? 1 : 0;
      if (!made.element.ok() && client->failed.ok()) client->failed = made.element.error();
    } else if (client->ahead.erase(made.key) > 0) {
      client->bricks_made += bricks;
      client->failed_ahead = client->failed_ahead || !made.element.ok();
    }
  }
}

}  // namespace gvx::engine
