/// \file
/// For tests of production: producers whose elements are made when the test says so, or with mistakes.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "gvx/produce/production.h"

namespace gvx::produce {

/// Bricks of u16 voxels whose value is x of the node; n = 2, m = 8.
class SmallProducer : public Producer {
 public:
  SmallProducer() {
    description_.m = 8;
    description_.max_level = 20;
    description_.format.type = VoxelType::u16;
  }
  const TreeDescription& description() const override { return description_; }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    for (std::size_t i = 0; i < keys.size(); ++i)
      infos[i] = {ValueRange{0, static_cast<float>(keys[i].x)}, false};
    return {};
  }
  /// Fails where y is 99, throws where it is 98.
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    ++made;
    if (key.y == 99) return Error{"no such brick"};
    if (key.y == 98) throw std::runtime_error("a bad day");
    for (std::size_t i = 0; i < voxels.size(); i += 2) voxels[i] = static_cast<std::byte>(key.x);
    return {};
  }
  mutable std::atomic<int> made{0};

 private:
  TreeDescription description_;
};

/// Files what is started; the test completes it, from any thread.
class RemoteProducer final : public SmallProducer {
 public:
  struct Request {
    std::shared_ptr<ElementSink> sink;
    std::size_t element = 0;
    ElementKind kind = ElementKind::brick;
    NodeKey node;

    void answer() const { sink->complete(element, made()); }
    Result<Element> made() const {
      const SmallProducer like;
      const auto one = std::make_shared<std::vector<std::byte>>(like.description().brick_bytes());
      GVX_TRY(like.produce(node, *one));
      Element brick;
      brick.voxels = *one;
      brick.memory = one;
      return brick;
    }
  };

  explicit RemoteProducer(std::size_t most_under_way, std::size_t most_in_batch = 1)
      : most_under_way_(most_under_way), most_in_batch_(most_in_batch) {}
  std::size_t most_under_way() const override { return most_under_way_; }
  Batching batching() const override { return {most_in_batch_, {}}; }
  void start(const ElementBatch& batch, std::shared_ptr<ElementSink> sink) const override {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < batch.nodes.size(); ++i)
      requests_.push_back({sink, i, batch.kind, batch.nodes[i]});
    came_.notify_all();
  }
  /// The requests that wait, once there are so many.
  std::vector<Request> take(std::size_t count) const {
    std::unique_lock lock(mutex_);
    came_.wait(lock, [&] { return requests_.size() >= count; });
    return std::exchange(requests_, {});
  }
  std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return requests_.size();
  }

 private:
  std::size_t most_under_way_, most_in_batch_;
  mutable std::mutex mutex_;
  mutable std::condition_variable came_;
  mutable std::vector<Request> requests_;
};

inline ElementKey brick_of(TreeId tree, std::uint64_t x, std::uint64_t y = 0) {
  return {tree, {10, x, y, 0}, ElementKind::brick};
}

inline std::vector<ElementKey> bricks_of(TreeId tree, std::uint64_t first, std::uint64_t count) {
  std::vector<ElementKey> keys;
  for (std::uint64_t i = 0; i < count; ++i) keys.push_back(brick_of(tree, first + i));
  return keys;
}

/// Far enough away: a test that waits so long has failed.
inline Production::Deadline in_a_minute() {
  return std::chrono::steady_clock::now() + std::chrono::minutes(1);
}

/// All that a client wants, once there is nothing left of it.
inline std::vector<FinishedElement> finish(Production& production, ClientId client) {
  std::vector<FinishedElement> all;
  while (!production.idle(client)) {
    production.wait_until(client, in_a_minute());
    for (FinishedElement& finished : production.take_finished()) all.push_back(std::move(finished));
  }
  return all;
}

}  // namespace gvx::produce
