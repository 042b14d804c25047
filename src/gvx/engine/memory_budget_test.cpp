#include "gvx/engine/memory_budget.h"

#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/engine/cache.h"
#include "gvx/produce/producer.h"

namespace gvx::engine {
namespace {

/// A producer that keeps as much as it may.
class Keeper final : public produce::Producer {
 public:
  explicit Keeper(std::uint64_t wanted) : wanted_(wanted) {
    tree_.m = 16;
    tree_.max_level = 8;
  }
  const produce::TreeDescription& description() const override { return tree_; }
  Status describe(std::span<const NodeKey>, std::span<tree::NodeInfo> infos) const override {
    for (tree::NodeInfo& info : infos) info = {ValueRange{0, 1}, false};
    return {};
  }
  Status produce(const NodeKey&, std::span<std::byte>) const override { return {}; }
  std::uint64_t wanted_memory() const override { return wanted_; }
  void keep_at_most(std::uint64_t bytes) const override { kept = bytes; }

  mutable std::uint64_t kept = UINT64_MAX;

 private:
  produce::TreeDescription tree_;
  std::uint64_t wanted_;
};

std::shared_ptr<Keeper> keeper(std::uint64_t wanted) {
  return std::make_shared<Keeper>(wanted);
}

std::uint64_t brick_bytes(const Volume& volume) {
  const Residency& residency = volume.residency();
  return (residency.bricks().slots() - residency.withheld_bricks()) * residency.bricks().brick_bytes();
}

TEST(MemoryBudget, nodes_and_producers_take_a_small_part_and_bricks_the_rest) {
  constexpr std::uint64_t kMemory = 64 << 20;
  CacheOptions options;
  options.memory_bytes = kMemory;
  const auto cache = Cache::create(exec::Device::cpu(1), options).value();
  const auto greedy = keeper(UINT64_MAX), modest = keeper(1000);
  const auto first = cache->open(greedy).value();
  EXPECT_EQ(greedy->kept, kMemory / 8);
  const std::uint64_t nodes = first->residency().nodes().bytes();
  EXPECT_LE(nodes, kMemory / 8);
  EXPECT_LE(brick_bytes(*first) + nodes + greedy->kept, kMemory);
  EXPECT_GT(brick_bytes(*first) + nodes + greedy->kept, kMemory - first->residency().bricks().brick_bytes());
  const auto second = cache->open(modest).value();
  EXPECT_EQ(greedy->kept, kMemory / 8 - 1000) << "what the other leaves";
  EXPECT_EQ(modest->kept, 1000u);
}

TEST(MemoryBudget, another_volume_gets_bricks_for_which_all_is_within_the_bound) {
  constexpr std::uint64_t kMemory = 8 << 20;
  CacheOptions options;
  options.memory_bytes = kMemory;
  const auto cache = Cache::create(exec::Device::cpu(1), options).value();
  std::vector<std::shared_ptr<Volume>> volumes;
  MemoryBudget budget(kMemory);
  for (int i = 0; i < 3; ++i) {
    volumes.push_back(cache->open(keeper(i == 1 ? UINT64_MAX : 0)).value());
    volumes.back()->residency().restore_bricks(volumes.back()->residency().withheld_bricks());
    budget.add(volumes.back().get());
  }
  const auto used = [&] {
    std::uint64_t bytes = kMemory / 8;  // what one producer keeps
    for (const auto& volume : volumes) bytes += brick_bytes(*volume) + volume->residency().nodes().bytes();
    return bytes;
  };
  for (const std::size_t wants : {1u, 2u, 0u, 1u}) {
    budget.make_room(*volumes[wants], 100, Eviction::unused);
    EXPECT_GE(volumes[wants]->residency().free_bricks(), 100u) << wants;
    EXPECT_LE(used(), kMemory) << wants;
  }
}

TEST(MemoryBudget, who_goes_leaves_its_part_to_others_as_far_as_there_is_room) {
  constexpr std::uint64_t kMemory = 16 << 20;
  const auto cache = Cache::create(exec::Device::cpu(1), {}).value();
  const auto a = keeper(UINT64_MAX), b = keeper(UINT64_MAX);
  const auto first = cache->open(a).value(), second = cache->open(b).value();
  MemoryBudget budget(kMemory);
  for (Volume* volume : {first.get(), second.get()}) {
    volume->residency().restore_bricks(volume->residency().withheld_bricks());
    budget.add(volume);
  }
  EXPECT_EQ(a->kept + b->kept, kMemory / 8);
  budget.make_room(*first, 1u << 20, Eviction::any);
  budget.remove(second.get());
  const std::uint64_t nodes = first->residency().nodes().bytes();
  EXPECT_LE(brick_bytes(*first) + nodes + a->kept, kMemory);
  EXPECT_GE(a->kept, kMemory / 16);
}

}  // namespace
}  // namespace gvx::engine
