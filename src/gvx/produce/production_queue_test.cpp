#include "gvx/produce/production_queue.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <stdexcept>

#include <gtest/gtest.h>

namespace gvx::produce {
namespace {

/// Makes bricks of one value, x of the key; fails where y is 99.
class CountingProducer : public Producer {
 public:
  CountingProducer() {
    description_.n = 2;
    description_.m = 8;
    description_.max_level = 8;
    description_.format.type = VoxelType::u16;
  }
  const TreeDescription& description() const override { return description_; }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    for (std::size_t i = 0; i < keys.size(); ++i)
      infos[i] = {ValueRange{0, static_cast<float>(keys[i].x)}, false};
    return {};
  }
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    ++made;
    if (key.y == 99) return Error{"no such brick"};
    if (key.y == 98) throw std::runtime_error("a bad day");
    const auto value = static_cast<std::uint16_t>(key.x);
    for (std::size_t i = 0; i < voxels.size(); i += 2) std::memcpy(&voxels[i], &value, 2);
    if (key.z == 1) voxels[0] = std::byte{255};
    return {};
  }
  mutable std::atomic<int> made{0};

 private:
  TreeDescription description_;
};

std::vector<Produced> finish(ProductionQueue& queue) {
  std::vector<Produced> all;
  while (!queue.idle()) {
    queue.wait();
    for (Produced& p : queue.take_finished()) all.push_back(std::move(p));
  }
  return all;
}

TEST(ProductionQueue, makes_every_job_once_and_recognises_constants) {
  const auto producer = std::make_shared<CountingProducer>();
  ProductionQueue queue(producer, 3);
  std::vector<Job> jobs;
  for (std::uint32_t x = 0; x < 200; ++x) jobs.push_back({{8, x, 0, x % 2}, JobKind::brick});
  jobs.push_back({{3, 4, 5, 6}, JobKind::children});
  jobs.push_back(jobs[0]);
  queue.replace(jobs);
  const auto made = finish(queue);
  ASSERT_EQ(made.size(), 201u);
  EXPECT_EQ(producer->made, 200);
  for (const Produced& p : made) {
    ASSERT_TRUE(p.status.ok());
    if (p.job.kind == JobKind::children) {
      EXPECT_EQ(p.child_keys[7], (NodeKey{4, 9, 11, 13}));
      EXPECT_EQ(p.children[1].ranges.channel[0], (ValueRange{0, 9}));
    } else {
      EXPECT_EQ(p.constant.has_value(), p.job.key.z == 0);
      if (p.constant) {
        EXPECT_EQ(p.constant->channel[0].minimum, static_cast<float>(p.job.key.x));
      }
    }
  }
}

TEST(ProductionQueue, hands_on_errors) {
  ProductionQueue queue(std::make_shared<CountingProducer>(), 2);
  queue.replace({{{1, 0, 99, 0}, JobKind::brick}, {{1, 1, 0, 0}, JobKind::brick}});
  const auto made = finish(queue);
  ASSERT_EQ(made.size(), 2u);
  const auto failed =
      std::find_if(made.begin(), made.end(), [](const Produced& p) { return !p.status.ok(); });
  ASSERT_NE(failed, made.end());
  EXPECT_EQ(failed->status.error().message, "no such brick");
}

TEST(ProductionQueue, turns_what_a_producer_throws_into_an_error) {
  ProductionQueue queue(std::make_shared<CountingProducer>(), 1);
  queue.replace({{{1, 0, 98, 0}, JobKind::brick}});
  const auto made = finish(queue);
  ASSERT_EQ(made.size(), 1u);
  ASSERT_FALSE(made[0].status.ok());
  EXPECT_NE(made[0].status.error().message.find("a bad day"), std::string::npos);
}

/// Likes batches of 16.
class BatchingProducer final : public CountingProducer {
 public:
  Batching batching() const override { return {16, {}}; }
  Status produce_batch(const BrickBatch& batch) const override {
    ++batches;
    std::size_t before = largest;
    while (before < batch.keys.size() && !largest.compare_exchange_weak(before, batch.keys.size())) {
    }
    return CountingProducer::produce_batch(batch);
  }
  mutable std::atomic<int> batches{0};
  mutable std::atomic<std::size_t> largest{0};
};

TEST(ProductionQueue, makes_batches_no_greater_than_a_producer_likes) {
  const auto producer = std::make_shared<BatchingProducer>();
  std::vector<Job> jobs;
  for (std::uint32_t x = 0; x < 1000; ++x) {
    jobs.push_back({{8, x, 0, 1}, JobKind::brick});
    if (x % 4 == 0) jobs.push_back({{3, x % 8, 5, x / 8}, JobKind::children});
  }
  ProductionQueue queue(producer, 2);
  queue.replace(jobs);
  const auto made = finish(queue);
  ASSERT_EQ(made.size(), jobs.size());
  EXPECT_EQ(producer->made, 1000);
  EXPECT_GT(producer->largest, 8u);
  EXPECT_LE(producer->largest, 16u);
  EXPECT_LT(producer->batches, 200);
  for (const Produced& p : made) {
    ASSERT_TRUE(p.status.ok());
    if (p.job.kind == JobKind::children) {
      EXPECT_EQ(p.child_keys[0], child(p.job.key, 2, 0));
      EXPECT_EQ(p.children[0].ranges.channel[0].maximum, static_cast<float>(2 * p.job.key.x));
    } else {
      std::uint16_t second = 0;
      std::memcpy(&second, &p.voxels[2], 2);
      EXPECT_EQ(second, p.job.key.x);
    }
  }
}

TEST(ProductionQueue, a_batch_fails_as_a_whole) {
  const BatchingProducer producer;
  const std::vector<Job> jobs = {
      {{8, 1, 0, 0}, JobKind::brick}, {{8, 1, 99, 0}, JobKind::brick}, {{1, 0, 0, 0}, JobKind::children}};
  const std::vector<Produced> made = make(producer, jobs);
  EXPECT_FALSE(made[0].status.ok());
  EXPECT_FALSE(made[1].status.ok());
  EXPECT_TRUE(made[2].status.ok());
}

TEST(ProductionQueue, an_interior_brick_of_one_value_is_no_constant) {
  const CountingProducer producer;
  EXPECT_TRUE(make(producer, {{8, 5, 0, 0}, JobKind::brick}).constant.has_value());
  EXPECT_FALSE(make(producer, {{7, 5, 0, 0}, JobKind::brick}).constant.has_value());
}

TEST(ProductionQueue, replacing_forgets_what_has_not_begun) {
  const auto producer = std::make_shared<CountingProducer>();
  ProductionQueue queue(producer, 1);
  std::vector<Job> many;
  for (std::uint32_t x = 0; x < 5000; ++x) many.push_back({{9, x, 0, 0}, JobKind::brick});
  queue.replace(many);
  queue.replace({});
  const auto made = finish(queue);
  EXPECT_LT(made.size(), 5000u);
  EXPECT_EQ(made.size(), static_cast<std::size_t>(producer->made));
}

TEST(ProductionQueue, stops_with_work_left) {
  ProductionQueue queue(std::make_shared<CountingProducer>(), 2);
  std::vector<Job> many;
  for (std::uint32_t x = 0; x < 100000; ++x) many.push_back({{9, x, 0, 0}, JobKind::brick});
  queue.replace(many);
  EXPECT_FALSE(queue.idle());
}

}  // namespace
}  // namespace gvx::produce
