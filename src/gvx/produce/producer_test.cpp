// The conformance suite of producers, for every implementation; and what each alone promises.

#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "gvx/brick/brick_layout.h"
#include "gvx/produce/amplify_producer.h"
#include "gvx/produce/hypertexture.h"
#include "gvx/produce/producer_test_support.h"
#include "gvx/produce/repeat_producer.h"
#include "gvx/produce/sponge_producer.h"
#include "gvx/produce/terrain.h"

namespace gvx::produce {
namespace {

/// Of a brick of 8^3 bytes (brick/brick_layout.h).
int texel(const std::vector<std::byte>& brick, int x, int y, int z) {
  return static_cast<int>(brick[static_cast<std::size_t>(brick::BrickLayout<8>::offset(x, y, z))]);
}

class EveryProducer : public testing::TestWithParam<ProducerCase> {};
INSTANTIATE_TEST_SUITE_P(, EveryProducer, testing::ValuesIn(every_producer()), name_of_case);

TEST_P(EveryProducer, canonical_is_a_fixed_point_with_the_same_description) {
  const auto producer = GetParam().make();
  for (const NodeKey& key : random_nodes(producer->description(), 500)) {
    const NodeKey canonical = producer->canonical(key);
    EXPECT_EQ(producer->canonical(canonical), canonical);
    tree::NodeInfo of_key, of_canonical;
    ASSERT_TRUE(producer->describe(std::span(&key, 1), std::span(&of_key, 1)).ok());
    ASSERT_TRUE(producer->describe(std::span(&canonical, 1), std::span(&of_canonical, 1)).ok());
    EXPECT_EQ(of_key.ranges, of_canonical.ranges);
  }
}

TEST_P(EveryProducer, writes_every_voxel_of_a_brick_and_its_border) {
  const auto producer = GetParam().make();
  const TreeDescription& tree = producer->description();
  const std::size_t planes = tree.format.planes * plane_texels(tree.m) * voxel_bytes(tree.format.type);
  int bricks = 0;
  for (const NodeKey& asked : random_nodes(tree, 100)) {
    const NodeKey key = producer->canonical(asked);
    tree::NodeInfo info;
    ASSERT_TRUE(producer->describe(std::span(&key, 1), std::span(&info, 1)).ok());
    if (info.ranges.constant()) continue;
    std::vector<std::byte> over_ones(tree.brick_bytes(), std::byte{0x11}),
        over_sevens(tree.brick_bytes(), std::byte{0x77});
    ASSERT_TRUE(producer->produce(key, over_ones).ok());
    ASSERT_TRUE(producer->produce(key, over_sevens).ok());
    ASSERT_EQ(std::memcmp(over_ones.data(), over_sevens.data(), planes), 0);
    ++bricks;
  }
  EXPECT_GT(bricks, 0);
}
TEST_P(EveryProducer, the_oracle_bounds_every_voxel_and_every_child) {
  const auto producer = GetParam().make();
  const TreeDescription& tree = producer->description();
  std::vector<std::byte> voxels(tree.brick_bytes());
  for (const NodeKey& asked : random_nodes(tree, 300)) {
    const NodeKey key = producer->canonical(asked);
    tree::NodeInfo info;
    ASSERT_TRUE(producer->describe(std::span(&key, 1), std::span(&info, 1)).ok());
    if (!info.ranges.constant()) {
      ASSERT_TRUE(producer->produce(key, voxels).ok());
      with_voxel_type(tree.format.type, [&](auto v) {
        for (std::size_t i = 0; i < plane_texels(tree.m); ++i) {
          std::memcpy(&v, &voxels[i * sizeof(v)], sizeof(v));
          ASSERT_TRUE(info.ranges.channel[0].contains(static_cast<float>(v))) << static_cast<float>(v);
        }
      });
    }
    if (info.terminal || key.level == tree.max_level) continue;
    const int n = static_cast<int>(tree.n);
    for (int i = 0; i < n * n * n; ++i) {
      const NodeKey below = producer->canonical(child(key, n, i));
      tree::NodeInfo child_info;
      ASSERT_TRUE(producer->describe(std::span(&below, 1), std::span(&child_info, 1)).ok());
      EXPECT_TRUE(info.ranges.contains(child_info.ranges));
    }
  }
}

TEST(SpongeProducer, is_the_root_again_in_20_of_27_places_at_every_depth) {
  const SpongeProducer sponge;
  NodeKey at;
  for (int depth = 0; depth < 10; ++depth) {
    int again = 0;
    for (int i = 0; i < 27; ++i) again += sponge.canonical(child(at, 3, i)) == NodeKey{} ? 1 : 0;
    EXPECT_EQ(again, 20);
    at = child(at, 3, depth % 2 == 0 ? 0 : 26);
  }
}

TEST(SparseField, is_near_the_field_and_the_same_in_blocks_that_overlap) {
  const auto balls = std::make_shared<BallsField>(std::vector<BallsField::Ball>{{Vec3d(0.5), 0.3}});
  const SparseField sparse(balls, 0.06);
  for (const double voxels : {64.0, 256.0, 1024.0}) {
    const double spacing = 1 / voxels;
    const auto block_at = [&](double x) {
      return VoxelBlock{spacing * (Vec3d(x, std::floor(0.4 * voxels), std::floor(0.5 * voxels)) - Vec3d(0.5)),
                        spacing, 18};
    };
    const double start = std::floor(0.2 * voxels / 16) * 16;
    std::vector<float> left(18 * 18 * 18), right(left.size()), exact(left.size());
    sparse.sample(block_at(start), left);
    sparse.sample(block_at(start + 16), right);
    balls->sample(block_at(start), exact);
    for (std::size_t i = 0; i < left.size(); ++i) ASSERT_NEAR(left[i], exact[i], 4e-4) << voxels;
    for (std::size_t row = 0; row < left.size(); row += 18) {
      ASSERT_EQ(left[row + 16], right[row]);
      ASSERT_EQ(left[row + 17], right[row + 1]);
    }
  }
}

TEST(AmplifyProducer, adds_detail_below_the_volumes_levels_and_nothing_at_them) {
  const auto plain = make_store_producer(), rich = amplified(plain);
  const std::uint32_t finest = plain->description().max_level;
  EXPECT_EQ(rich->description().max_level, finest + 3);
  std::vector<std::byte> mine(plain->description().brick_bytes()), volumes(mine.size());
  const NodeKey node{finest, 1, 1, 1};
  ASSERT_TRUE(rich->produce(node, mine).ok());
  ASSERT_TRUE(plain->produce(node, volumes).ok());
  EXPECT_EQ(mine, volumes);
  // Two neighbours a level below agree where they meet: the one's border is the other's first layer.
  std::vector<std::byte> left(mine.size()), right(mine.size());
  ASSERT_TRUE(rich->produce({finest + 2, 5, 5, 5}, left).ok());
  ASSERT_TRUE(rich->produce({finest + 2, 6, 5, 5}, right).ok());
  int differences = 0, changes = 0;
  for (int row = 0; row < 144; ++row) {
    const int y = row % 12 - 1, z = row / 12 - 1;
    for (int border = -1; border <= 2; ++border) {
      differences += std::abs(texel(left, 8 + border, y, z) - texel(right, border, y, z)) > 1 ? 1 : 0;
    }
    changes += texel(left, 3, y, z) != texel(left, 4, y, z) ? 1 : 0;
  }
  EXPECT_EQ(differences, 0);
  EXPECT_GT(changes, 50);
}

TEST(AmplifyProducer, goes_on_from_what_is_amplified_already) {
  // With no noise of its own the outer one mixes between the inner one's voxels.
  const auto inner = amplified(make_store_producer());
  AmplifyOptions still;
  still.levels = 1;
  still.strength = 0;
  const auto outer = AmplifyProducer::create(inner, still).value();
  const std::uint32_t finest = inner->description().max_level;
  std::vector<std::byte> coarse(inner->description().brick_bytes()), fine(coarse.size());
  ASSERT_TRUE(inner->produce({finest, 10, 10, 10}, coarse).ok());
  ASSERT_TRUE(outer->produce({finest + 1, 20, 20, 20}, fine).ok());
  for (int x = 1; x < 9; ++x) {
    double sum = 0;
    // A voxel of half the width is a quarter of one beside the middle of that which holds it.
    for (int i = 0; i < 8; ++i) {
      const auto place = [&](int v, bool other) { return (v + 1) / 2 + (other ? (v % 2 == 0 ? 1 : -1) : 0); };
      const auto weight = [](bool other) { return other ? 0.25 : 0.75; };
      const bool a = (i & 1) != 0, b = (i & 2) != 0, c = (i & 4) != 0;
      sum += weight(a) * weight(b) * weight(c) * texel(coarse, place(x, a), place(4, b), place(5, c));
    }
    EXPECT_NEAR(texel(fine, x, 4, 5), sum, 0.51) << x;
  }
}

TEST(RepeatProducer, copies_share_all_nodes_and_have_the_volumes_bricks) {
  const auto one = make_store_producer(), many = repeated(one, 3);
  const TreeDescription& tree = many->description();
  EXPECT_EQ(tree.max_level, one->description().max_level + 3);
  std::mt19937 random(8);
  std::vector<std::byte> mine(tree.brick_bytes()), volumes(tree.brick_bytes());
  for (int i = 0; i < 200; ++i) {
    const std::uint32_t level = static_cast<std::uint32_t>(random()) % (one->description().max_level + 1);
    const std::uint32_t within = static_cast<std::uint32_t>(random()) % (1u << level),
                        copy = static_cast<std::uint32_t>(random()) % 8;
    const NodeKey inner{level, within, within / 2, 0};
    const NodeKey key{level + 3, (copy << level) + within, ((7 - copy) << level) + within / 2, copy << level};
    EXPECT_EQ(many->canonical(key), (NodeKey{level + 3, within, within / 2, 0}));
    tree::NodeInfo of_key, of_inner;
    ASSERT_TRUE(many->describe(std::span(&key, 1), std::span(&of_key, 1)).ok());
    ASSERT_TRUE(one->describe(std::span(&inner, 1), std::span(&of_inner, 1)).ok());
    EXPECT_EQ(of_key.ranges, of_inner.ranges);
    if (of_inner.ranges.constant()) continue;
    ASSERT_TRUE(many->produce(many->canonical(key), mine).ok());
    ASSERT_TRUE(one->produce(inner, volumes).ok());
    EXPECT_EQ(mine, volumes);
  }
}

TEST(RepeatProducer, levels_above_the_copies_are_means_that_go_on_beyond_the_border) {
  const auto many = repeated(make_density(std::make_shared<TerrainField>(TerrainOptions{}), 8), 2);
  std::vector<std::byte> inner(many->description().brick_bytes()), outer(inner.size());
  ASSERT_TRUE(many->produce({2, 0, 0, 0}, inner).ok());
  ASSERT_TRUE(many->produce({1, 0, 0, 0}, outer).ok());
  // Two copies along an axis, of four voxels each.
  for (int z = -1; z < 11; ++z) {
    for (int y = -1; y < 11; ++y) {
      for (int x = -1; x < 11; ++x) {
        int sum = 0;
        for (int i = 0; i < 8; ++i) {
          const auto place = [](int voxel, int half) { return 1 + (voxel + 7) % 4 * 2 + half; };
          sum += texel(inner, place(x, i & 1), place(y, i >> 1 & 1), place(z, i >> 2));
        }
        ASSERT_EQ(texel(outer, x, y, z), (sum + 4) / 8);
      }
    }
  }
}

TEST(RepeatProducer, refuses_what_no_key_can_name) {
  EXPECT_FALSE(RepeatProducer::create(make_store_producer(), 40).ok());
  EXPECT_FALSE(RepeatProducer::create(make_field_producer(), 1).ok());
}

TEST(FieldProducer, samples_at_voxel_centres) {
  const auto producer = make_field_producer();
  std::vector<std::byte> bytes(producer->description().brick_bytes());
  ASSERT_TRUE(producer->produce(NodeKey{1, 2, 0, 1}, bytes).ok());
  float value;
  const auto texel = static_cast<std::size_t>(brick::BrickLayout<8>::offset(5, 2, 3));  // voxel (4, 1, 2)
  std::memcpy(&value, &bytes[texel * sizeof(float)], sizeof(float));
  const Vec3d p{(2 + 4.5 / 8) / 3, (0 + 1.5 / 8) / 3, (1 + 2.5 / 8) / 3};
  EXPECT_NEAR(value, p.x + 2 * p.y - p.z, 1e-6);
}

}  // namespace
}  // namespace gvx::produce
