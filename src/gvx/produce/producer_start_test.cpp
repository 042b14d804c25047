// The conformance suite of Producer::start(), for every implementation; and that canonical() reads nothing.

#include <algorithm>
#include <atomic>
#include <cstring>

#include <gtest/gtest.h>

#include "gvx/produce/examine_element.h"
#include "gvx/produce/field_kernels.h"
#include "gvx/produce/producer_test_support.h"
#include "gvx/produce/terrain.h"

namespace gvx::produce {
namespace {

/// Keeps what it is given. All producers of this suite hand over before start() returns.
class KeepingSink final : public ElementSink {
 public:
  explicit KeepingSink(std::size_t elements) : made(elements) {}
  void complete(std::size_t element, Result<Element> result) override {
    EXPECT_FALSE(made.at(element)) << "handed over twice";
    made.at(element).emplace(std::move(result));
  }
  bool cancelled(std::size_t) override { return false; }
  void drop(std::size_t element) override { ADD_FAILURE() << "dropped " << element; }

  std::vector<std::optional<Result<Element>>> made;
};

std::vector<Element> start(const Producer& producer, ElementKind kind, std::span<const NodeKey> nodes) {
  const auto sink = std::make_shared<KeepingSink>(nodes.size());
  producer.start({kind, nodes}, sink);
  EXPECT_EQ(sink.use_count(), 1);
  std::vector<Element> elements;
  for (auto& made : sink->made) elements.push_back(std::move(made.value()).value());
  return elements;
}

/// Canonical nodes that have a brick.
std::vector<NodeKey> nodes_with_bricks(const Producer& producer, int count) {
  std::vector<NodeKey> nodes;
  for (const NodeKey& key : random_nodes(producer.description(), count)) {
    const NodeKey one = producer.canonical(key);
    tree::NodeInfo info;
    EXPECT_TRUE(producer.describe(std::span(&one, 1), std::span(&info, 1)).ok());
    if (!info.ranges.constant()) nodes.push_back(one);
  }
  return nodes;
}

std::vector<ProducerCase> every_producer_that_starts() {
  std::vector<ProducerCase> cases = every_producer();
  cases.push_back({"terrain_kernel", [] {
                     TreeDescription tree;
                     tree.m = 8;
                     tree.max_level = 6;
                     tree.scale = 1.0 / 255;
                     return make_terrain_producer(exec::Device::cpu(2), tree, {});
                   }});
  cases.push_back({"deepened", [] {
                     return deepened(make_density(std::make_shared<TerrainField>(TerrainOptions{}), 8));
                   }});
  return cases;
}

class EveryStart : public testing::TestWithParam<ProducerCase> {};
INSTANTIATE_TEST_SUITE_P(, EveryStart, testing::ValuesIn(every_producer_that_starts()), name_of_case);

TEST_P(EveryStart, hands_over_each_brick_as_produce_makes_it) {
  const auto producer = GetParam().make();
  const TreeDescription& tree = producer->description();
  std::vector<NodeKey> nodes = nodes_with_bricks(*producer, 40);
  ASSERT_FALSE(nodes.empty());
  nodes.resize(std::min<std::size_t>(nodes.size(), 7));
  const std::vector<Element> bricks = start(*producer, ElementKind::brick, nodes);
  ASSERT_EQ(bricks.size(), nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    ASSERT_TRUE(check_size(tree, nodes[i], ElementKind::brick, bricks[i]).ok());
    std::vector<std::byte> expected(tree.brick_bytes());
    ASSERT_TRUE(producer->produce(nodes[i], expected).ok());
    EXPECT_TRUE(std::ranges::equal(bricks[i].voxels, expected));
    EXPECT_TRUE(bricks[i].child_keys.empty());
  }
}

TEST_P(EveryStart, hands_over_the_canonical_children_as_describe_does) {
  const auto producer = GetParam().make();
  const TreeDescription& tree = producer->description();
  std::vector<NodeKey> nodes = nodes_with_bricks(*producer, 40);
  std::erase_if(nodes, [&](const NodeKey& node) { return node.level >= tree.max_level; });
  ASSERT_FALSE(nodes.empty());
  const std::vector<Element> parents = start(*producer, ElementKind::children, nodes);
  ASSERT_EQ(parents.size(), nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    ASSERT_TRUE(check_size(tree, nodes[i], ElementKind::children, parents[i]).ok());
    EXPECT_TRUE(parents[i].voxels.empty());
    for (std::size_t c = 0; c < parents[i].children.size(); ++c) {
      const NodeKey key = producer->canonical(child(nodes[i], static_cast<int>(tree.n), static_cast<int>(c)));
      EXPECT_EQ(parents[i].child_keys[c], key);
      tree::NodeInfo info;
      ASSERT_TRUE(producer->describe(std::span(&key, 1), std::span(&info, 1)).ok());
      EXPECT_EQ(parents[i].children[c].ranges, info.ranges);
      EXPECT_EQ(parents[i].children[c].terminal, info.terminal);
    }
  }
}

TEST_P(EveryStart, takes_no_nodes_at_all) {
  const auto producer = GetParam().make();
  EXPECT_TRUE(start(*producer, ElementKind::brick, {}).empty());
  EXPECT_TRUE(start(*producer, ElementKind::children, {}).empty());
}

TEST_P(EveryStart, canonical_reads_no_bytes) {
  const auto producer = GetParam().make();
  const std::uint64_t before = producer->bytes_read();
  for (const NodeKey& key : random_nodes(producer->description(), 500)) producer->canonical(key);
  EXPECT_EQ(producer->bytes_read(), before);
}

/// A volume that counts how often it is asked for what it may have to read.
class CountingVolume final : public Producer {
 public:
  CountingVolume() : volume_(make_density(std::make_shared<TerrainField>(TerrainOptions{}), 8)) {}
  const TreeDescription& description() const override { return volume_->description(); }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    ++reads;
    return volume_->describe(keys, infos);
  }
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    ++reads;
    return volume_->produce(key, voxels);
  }
  mutable std::atomic<int> reads{0};

 private:
  std::shared_ptr<const Producer> volume_;
};

class EveryWrapper : public testing::TestWithParam<const char*> {
 protected:
  static std::shared_ptr<const Producer> wrap(const std::string& how,
                                              std::shared_ptr<const Producer> volume) {
    if (how == "amplified") return amplified(std::move(volume));
    if (how == "repeated") return repeated(std::move(volume), 3);
    if (how == "deepened") return deepened(std::move(volume));
    return repeated(amplified(std::move(volume)), 2);
  }
};
INSTANTIATE_TEST_SUITE_P(, EveryWrapper,
                         testing::Values("amplified", "repeated", "deepened", "repeated_amplified"),
                         [](const auto& tested) { return std::string(tested.param); });

TEST_P(EveryWrapper, canonical_asks_nothing_of_the_volume) {
  const auto volume = std::make_shared<CountingVolume>();
  const auto wrapped = wrap(GetParam(), volume);
  const int before = volume->reads;
  for (const NodeKey& key : random_nodes(wrapped->description(), 500)) wrapped->canonical(key);
  EXPECT_EQ(volume->reads, before);
}

TEST(DeeperProducer, hands_on_how_the_tree_starts) {
  /// Says how many batches it likes, and refuses all.
  class Refusing final : public Producer {
   public:
    const TreeDescription& description() const override { return description_; }
    Status describe(std::span<const NodeKey>, std::span<tree::NodeInfo>) const override { return {}; }
    Status produce(const NodeKey&, std::span<std::byte>) const override { return {}; }
    void start(const ElementBatch&, std::shared_ptr<ElementSink> sink) const override {
      sink->complete(0, Error{"closed today"});
    }
    std::size_t most_under_way() const override { return 50; }

   private:
    TreeDescription description_;
  };
  const auto deeper = deepened(std::make_shared<Refusing>());
  EXPECT_EQ(deeper->most_under_way(), 50u);
  const auto made = make_element(*deeper, {}, ElementKind::brick);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.error().message, "closed today");
}

TEST(AmplifyProducer, a_node_is_described_as_before_where_the_volume_is_constant) {
  // Nothing below a constant node is asked for, so it needs no other node to stand for it.
  const auto rich = amplified(make_store_producer());
  int constant = 0;
  for (const NodeKey& key : random_nodes(rich->description(), 300)) {
    EXPECT_EQ(rich->canonical(key), key);
    tree::NodeInfo info;
    ASSERT_TRUE(rich->describe(std::span(&key, 1), std::span(&info, 1)).ok());
    constant += info.ranges.constant() ? 1 : 0;
  }
  EXPECT_GT(constant, 0);
}

TEST(MakeElement, examines_what_it_makes) {
  const auto terrain = make_density(std::make_shared<TerrainField>(TerrainOptions{}), 8);
  const auto brick = make_element(*terrain, nodes_with_bricks(*terrain, 20).front(), ElementKind::brick);
  ASSERT_TRUE(brick.ok());
  ASSERT_TRUE(brick.value().found);
  const auto [least, greatest] = std::ranges::minmax(brick.value().voxels.first(plane_texels(8)));
  const ValueRange expected{static_cast<float>(least), static_cast<float>(greatest)};
  EXPECT_EQ(brick.value().found->channel[0], expected);
}

}  // namespace
}  // namespace gvx::produce
