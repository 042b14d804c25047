/// \file
/// Cache: what all viewers share: the volumes' trees as far as they are in memory, what makes their bricks,
/// and whose turn it is. Viewers ask it for what their rays lack; what several ask for is made once.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

#include "gvx/cache/pass_clock.h"
#include "gvx/core/result.h"
#include "gvx/engine/memory_budget.h"
#include "gvx/engine/surface.h"
#include "gvx/engine/volume.h"
#include "gvx/exec/device.h"
#include "gvx/exec/fair_mutex.h"
#include "gvx/produce/producer.h"
#include "gvx/produce/production.h"

namespace gvx::engine {

struct CacheOptions {
  std::uint64_t memory_bytes = 512ull << 20;  ///< for bricks, nodes, and what producers keep
  std::optional<PoolSizes> pools = {};        ///< of each volume, in place of memory_bytes; for tests
  /// Called with a line of text if something is wrong that is not an error. Today this happens once for each
  /// volume, for the first brick with values beyond its node's bounds. It is called on a viewer's thread.
  std::function<void(const std::string&)> warn = {};
};

/// Functions that viewers call are for one thread at a time: the one that has the turn.
class Cache {
 public:
  using ElementSet = std::unordered_set<produce::ElementKey, produce::ElementKeyHash>;

  /// What the cache keeps of one viewer.
  struct Client {
    cache::PassClock::Walker walker{};
    produce::ClientId producing{};
    std::uint32_t pass = 0;                ///< the number of its last pass
    Eviction eviction = Eviction::unused;  ///< what may make room for what it wants
    ElementSet visible, ahead;             ///< what it wants for its picture, and for one that may come
    Status failed;                         ///< why something for its picture could not be made
    bool failed_ahead = false;             ///< something for later could not be made
    std::uint64_t came = 0;                ///< elements for its picture
    std::uint64_t bricks_made = 0, bricks_evicted = 0;  ///< for it
  };

  static Result<std::shared_ptr<Cache>> create(const exec::Device& device, const CacheOptions& options);
  ~Cache();
  Cache(const Cache&) = delete;
  Cache& operator=(const Cache&) = delete;

  /// The volume of a producer; the same volume each time. An error if the program has no kernels for its
  /// voxels, or if the memory is too little. A volume that nobody holds any more is closed when the next one
  /// is opened or a viewer leaves.
  Result<std::shared_ptr<Volume>> open(std::shared_ptr<const produce::Producer> producer);

  /// The same for the producer of a surface: one whose tree's description says so.
  Result<std::shared_ptr<Surface>> open_surface(std::shared_ptr<const produce::Producer> producer);

  const exec::Device& device() const { return device_; }
  /// How long producers' threads have worked, all of them together.
  double making_milliseconds() const { return production_->making_milliseconds(); }

  // For viewers, on any thread:

  [[nodiscard]] exec::FairMutex::Turn take_turn() { return turns_.take(); }
  /// Does a viewer wait for its turn?
  bool contended() const { return turns_.contended(); }
  /// Waits until something is made that the client wants, or nothing is left to make for it.
  void wait_until(const Client& client, std::chrono::steady_clock::time_point deadline);

  // For the viewer that has the turn:

  Client* add_client();
  void remove_client(Client* client);
  bool has_one_client() const { return clients_.size() == 1; }
  /// A client's rays begin to march: their stamps carry the number that this returns.
  std::uint32_t begin_pass(Client& client);
  /// A client's rays have nothing more to do: what they touched may go.
  void rest(Client& client) { clock_.rest(client.walker); }

  /// What the rays of a client's last pass lack in these volumes, the most urgent first, each once; adds to
  /// `requests` how many nodes they marked.
  std::vector<produce::ElementKey> collect(const Client& client, std::span<Volume* const> volumes,
                                           std::uint64_t& requests);
  /// Makes room for elements, and drops those, from the back, that there is none for; returns whether there
  /// were any.
  bool limit_to_room(std::vector<produce::ElementKey>& elements, Eviction eviction);
  /// An element of a surface that a picture lacks.
  struct SurfaceElement {
    produce::ElementKey key;
    std::uint64_t bytes = 0;
  };
  /// Makes room for as many of these as possible, from the first on, and returns them.
  std::vector<produce::ElementKey> limit_to_room(const std::vector<SurfaceElement>& elements,
                                                 Eviction eviction);
  /// Has these made for the picture, or for a later one, in place of what was wanted before.
  void want(Client& client, produce::Tier tier, const std::vector<produce::ElementKey>& elements);
  /// Is nothing left to make, or to commit, of what the client wants for its picture?
  bool idle(const Client& client) const { return client.visible.empty(); }
  /// Takes in what was made: for the client, and, where it makes no room for itself by force, for all.
  void commit(Client& client);

 private:
  Cache(const exec::Device& device, const CacheOptions& options);

  void forget_closed();
  Volume* volume_of(produce::TreeId tree) const;
  Surface* surface_of(produce::TreeId tree) const;
  std::uint64_t take_in(std::vector<produce::FinishedElement> made, Eviction eviction);
  void tell(const produce::FinishedElement& made);

  exec::Device device_;
  CacheOptions options_;
  exec::FairMutex turns_;
  std::shared_ptr<produce::Production> production_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<std::shared_ptr<Volume>> volumes_;
  std::vector<std::shared_ptr<Surface>> surfaces_;
  MemoryBudget budget_;
  std::vector<produce::FinishedElement>
      others_;  // that were made while a client made room by force: they wait
  cache::PassClock clock_;
};

}  // namespace gvx::engine
