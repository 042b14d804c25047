/// \file
/// PageCache: keeps index pages up to a bound in bytes; the least recently used goes first. Where several
/// threads lack the same page, one of them reads it and the others wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/format.h"

namespace gvx::store {

/// The bytes of a page, decompressed.
using Page = std::shared_ptr<const std::vector<std::byte>>;

/// What a page is known by. Two that agree in this are the same bytes, read in the same way.
struct PageKey {
  PageRef ref{};
  bool of_records = false;  ///< else of references to other pages

  constexpr bool operator==(const PageKey&) const = default;
};

/// Thread-safe.
class PageCache {
 public:
  /// Pages that are being read come on top of the bound: one a thread.
  explicit PageCache(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// The page of the key, read by load() where it is not here. An error of load() goes to all that wait, and
  /// is not kept.
  template <typename Load>
  Result<Page> get(const PageKey& key, const Load& load) {
    std::promise<Result<Page>> promise;
    {
      std::unique_lock lock(mutex_);
      if (const auto found = slots_.find(key); found != slots_.end()) {
        order_.splice(order_.begin(), order_, found->second.place);
        const std::shared_future<Result<Page>> page = found->second.page;
        lock.unlock();
        return page.get();
      }
      order_.push_front(key);
      slots_.emplace(key, Slot{promise.get_future().share(), order_.begin(), 0});
    }
    Result<Page> page = load();
    promise.set_value(page);
    finish_load(key, page);
    return page;
  }

  /// What is counted of a page beside its bytes: about what this class keeps for it.
  static constexpr std::size_t kOfEach = 256;

  /// Bytes that the kept pages take, with what this class stores for each.
  std::size_t bytes() const;
  /// Another bound from now on.
  void set_bound(std::size_t most_bytes);

 private:
  struct Slot {
    std::shared_future<Result<Page>> page;
    std::list<PageKey>::iterator place;
    std::size_t bytes;  ///< 0 while it is being read
  };
  struct Hash {
    std::size_t operator()(const PageKey& key) const;
  };

  /// Counts a page that was read; forgets one that was not.
  void finish_load(const PageKey& key, const Result<Page>& page);

  /// Drops the oldest pages beyond the bound.
  void drop_oldest();

  mutable std::mutex mutex_;
  std::size_t most_bytes_;
  std::size_t bytes_ = 0;
  std::list<PageKey> order_;  ///< what was asked for last is first
  std::unordered_map<PageKey, Slot, Hash> slots_;
};

}  // namespace gvx::store
