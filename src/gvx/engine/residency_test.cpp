// Model-based: random sequences of uses, requests, commits, evictions and changes of function must keep every
// invariant of tree and caches, with and without shared sub-trees.

#include "gvx/engine/residency.h"

#include <algorithm>
#include <random>
#include <unordered_set>
#include <utility>

#include <gtest/gtest.h>

#include "gvx/produce/examine_element.h"
#include "gvx/produce/field_producer.h"
#include "gvx/produce/sponge_producer.h"

namespace gvx::engine {
namespace {

using produce::ElementKey;
using produce::ElementKind;
using produce::FinishedElement;

constexpr produce::TreeId kTree(7);

FinishedElement make(const produce::Producer& producer, const ElementKey& key) {
  return {key, produce::make_element(producer, key.node, key.kind)};
}

/// A ramp along x whose right part is one value.
std::shared_ptr<const produce::Producer> ramp(std::uint32_t n) {
  produce::TreeDescription tree;
  tree.n = n;
  tree.m = 8;
  tree.max_level = 4;
  return std::make_shared<produce::FieldProducer>(
      tree, [](Vec3d p) { return static_cast<float>(std::min(p.x, 0.7)); },
      [](const Box3d& b) {
        return ValueRange{static_cast<float>(std::min(b.minimum.x, 0.7)),
                          static_cast<float>(std::min(b.maximum.x, 0.7))};
      });
}

/// The eight octants of the cube are one another's copies: N = 2 with instancing on the first level.
class Repeated final : public produce::Producer {
 public:
  Repeated() : below_(ramp(2)) {}
  const produce::TreeDescription& description() const override { return below_->description(); }
  NodeKey canonical(const NodeKey& key) const override {
    if (key.level == 0) return key;
    const std::uint32_t across = 1u << (key.level - 1);
    return {key.level, key.x % across, key.y % across, key.z % across};
  }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    return below_->describe(keys, infos);
  }
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    return below_->produce(key, voxels);
  }

 private:
  std::shared_ptr<const produce::Producer> below_;
};

struct Case {
  const char* name;
  std::shared_ptr<const produce::Producer> (*producer)();
  PoolSizes sizes;
};

class RandomWalk : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(
    , RandomWalk,
    testing::Values(
        Case{"octree", [] { return ramp(2); }, {40, 20}}, Case{"octree_tiny", [] { return ramp(2); }, {7, 2}},
        Case{"n3", [] { return ramp(3); }, {12, 30}},
        Case{"repeated", [] { return std::shared_ptr<const produce::Producer>(new Repeated); }, {30, 12}},
        Case{"sponge",
             [] { return std::shared_ptr<const produce::Producer>(new produce::SpongeProducer(8)); },
             {5, 3}}),
    [](const auto& tested) { return tested.param.name; });

TEST_P(RandomWalk, keeps_every_invariant) {
  const auto producer = GetParam().producer();
  const int n = static_cast<int>(producer->description().n);
  Residency residency(exec::Device::cpu(2), *producer, kTree, GetParam().sizes);
  ASSERT_TRUE(residency.plant_root().ok());
  // Two viewers; one comes late.
  const PoolSizes sizes = GetParam().sizes;
  Look first(exec::Device::cpu(2), sizes.tiles, sizes.bricks);
  Look second(exec::Device::cpu(2), sizes.tiles, sizes.bricks);
  residency.attach(first);
  std::mt19937 generator(21);
  const auto random = [&](std::uint32_t below) { return static_cast<std::uint32_t>(generator()) % below; };

  std::vector<scene::TransferTable> tables;
  const auto seen_by = [&](std::uint32_t table) {
    scene::Visibility visibility;
    visibility.functions[0] = tables[table].view();
    return visibility;
  };
  for (const double from : {0.0, 0.35, 0.9}) {
    tables.push_back(scene::bake({{{0, {1, 1, 1}}}, {{from, 0}, {1, 1}}, 0, {}}, 1, 0, 16));
  }
  std::vector<FinishedElement> late;  // made, but committed in a later pass
  std::uint64_t committed = 0, linked = 0;
  for (std::uint32_t pass = 1; pass <= 400; ++pass) {
    if (pass == 50) residency.attach(second);
    if (random(25) == 0) residency.set_visibility(first, seen_by(random(3)));
    if (pass >= 50 && random(25) == 0) residency.set_visibility(second, seen_by(random(3)));
    // Rays: walks from the root that stamp what they use and mark what they lack.
    for (int ray = 0; ray < 12; ++ray) {
      NodeIndex node = tree::NodePool::root();
      for (std::uint32_t level = 0;; ++level) {
        residency.tile_usage().touch(residency.nodes().tile_of(node).value, pass);
        const auto word = residency.nodes().child(node);
        const auto content = residency.nodes().content(node);
        if (content.kind() == tree::ContentKind::brick) {
          residency.brick_usage().touch(content.brick().value, pass);
          ++linked;
        } else if (content.kind() == tree::ContentKind::none) {
          residency.requests().request(node, cache::kNeedsBrick, 0.5f);
        }
        if (word.terminal() || level == 6) break;
        if (!word.has_children()) {
          residency.requests().request(node, cache::kNeedsChildren, 0.25f);
          break;
        }
        node = residency.nodes().node_of(word.children(), random(static_cast<std::uint32_t>(n * n * n)));
      }
    }
    const std::vector<Lacking> lacking = residency.collect(pass, pass - std::min(pass, random(3)));
    residency.check_invariants();
    std::unordered_set<ElementKey, produce::ElementKeyHash> seen;
    for (const auto& [key, priority] : lacking) {
      ASSERT_TRUE(seen.insert(key).second) << "an element was listed twice";
      ASSERT_EQ(key.tree, kTree);
      ASSERT_EQ(producer->canonical(key.node), key.node);
    }
    ASSERT_TRUE(std::is_sorted(lacking.begin(), lacking.end(), more_urgent));
    const Eviction eviction = random(3) == 0 ? Eviction::any : Eviction::unused;
    Room room = residency.room(eviction);
    const bool limited = random(2) == 0;
    std::vector<FinishedElement> made = std::exchange(late, {});
    for (const auto& [key, priority] : lacking) {
      if (limited && !room.take(key.kind)) continue;
      (random(4) == 0 ? late : made).push_back(make(*producer, key));
    }
    if (random(9) == 0 && residency.room(Eviction::any).bricks > 2) residency.withhold_bricks(1);
    if (random(9) == 0) residency.restore_bricks(residency.withheld_bricks());
    const std::size_t offered = made.size();
    residency.commit(std::move(made), eviction);
    committed += offered;
    residency.check_invariants();
  }
  EXPECT_GT(committed, 0u);
  EXPECT_GT(linked, 100u);
}

TEST(Residency, sponge_needs_one_tile_and_one_brick_for_any_depth) {
  const produce::SpongeProducer sponge(8);
  Residency residency(exec::Device::cpu(1), sponge, kTree, {3, 2});
  ASSERT_TRUE(residency.plant_root().ok());
  residency.requests().request(tree::NodePool::root(), cache::kNeedsBrick | cache::kNeedsChildren, 1);
  std::vector<FinishedElement> made;
  for (const auto& lacking : residency.collect(1, 1)) made.push_back(make(sponge, lacking.element));
  ASSERT_EQ(made.size(), 2u);
  residency.commit(std::move(made), Eviction::unused);
  NodeIndex node = tree::NodePool::root();
  for (int depth = 0; depth < 20; ++depth) {
    ASSERT_TRUE(residency.nodes().child(node).has_children()) << depth;
    ASSERT_EQ(residency.nodes().content(node).kind(), tree::ContentKind::brick) << depth;
    node = residency.nodes().node_of(residency.nodes().child(node).children(), 0);
  }
  EXPECT_EQ(residency.resident_bricks(), 1u);
}

TEST(Residency, what_failed_is_passed_over_and_the_rest_committed) {
  const auto producer = ramp(2);
  Residency residency(exec::Device::cpu(1), *producer, kTree, {20, 20});
  ASSERT_TRUE(residency.plant_root().ok());
  residency.requests().request(tree::NodePool::root(), cache::kNeedsBrick | cache::kNeedsChildren, 1);
  std::vector<FinishedElement> made;
  for (const auto& lacking : residency.collect(1, 1)) made.push_back(make(*producer, lacking.element));
  ASSERT_EQ(made.size(), 2u);
  (made[0].key.kind == ElementKind::brick ? made[0] : made[1]).element = Error{"brick is gone"};
  residency.commit(std::move(made), Eviction::unused);
  EXPECT_TRUE(residency.nodes().child(tree::NodePool::root()).has_children());
  EXPECT_EQ(residency.resident_bricks(), 0u);
}

TEST(PoolSizes, fit_the_memory_and_the_tree) {
  produce::TreeDescription tree;
  tree.m = 16;
  tree.format.type = VoxelType::u8;
  tree.bricks = 1000000;
  const PoolSizes sizes = PoolSizes::fitting(64ull << 20, tree).value();
  EXPECT_EQ(sizes.bricks, (64u << 20) / (20 * 20 * 20 + 4 + 10 * 10 * 10));
  tree.bricks = 10;
  EXPECT_EQ(PoolSizes::fitting(64ull << 20, tree).value().bricks, 11u);
  EXPECT_FALSE(PoolSizes::fitting(10000, tree).ok());
}

}  // namespace
}  // namespace gvx::engine
