#include "gvx/tree/node_pool.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/tree/hidden_nodes.h"

namespace gvx::tree {
namespace {

TEST(NodePool, words_keep_their_parts_apart) {
  NodePool pool(exec::Device::cpu(), 2, 10, 1);
  const NodeIndex node = pool.node_of(TileIndex(3), 5);
  pool.reset_node(node, {ValueRange{1, 4}, false});
  pool.set_children(node, TileIndex(7));
  pool.set_content(node, ContentWord::of_brick(BrickIndex(123456)));
  EXPECT_EQ(pool.child(node).children(), TileIndex(7));
  EXPECT_FALSE(pool.child(node).terminal());
  EXPECT_EQ(pool.content(node).kind(), ContentKind::brick);
  EXPECT_EQ(pool.content(node).brick(), BrickIndex(123456));
  EXPECT_EQ(pool.tile_of(node), TileIndex(3));
}

TEST(HiddenNodes, bits_of_a_tile_are_apart) {
  HiddenNodes hidden(exec::Device::cpu(), 4);
  hidden.set_tile(TileIndex(2), 0x7ffffff);
  hidden.set(TileIndex(2), 26, false);
  hidden.set(TileIndex(3), 26, true);
  for (std::uint32_t i = 0; i < 27; ++i) {
    EXPECT_FALSE(hidden.at(TileIndex(1), i));
    EXPECT_EQ(hidden.at(TileIndex(2), i), i != 26);
    EXPECT_EQ(hidden.at(TileIndex(3), i), i == 26);
  }
}

TEST(NodePool, a_range_of_one_value_is_a_constant_terminal_node) {
  NodePool pool(exec::Device::cpu(), 3, 4, 1);
  pool.reset_node(NodeIndex(30), {ValueRange{5, 5}, false});
  EXPECT_EQ(pool.content(NodeIndex(30)).kind(), ContentKind::constant);
  EXPECT_TRUE(pool.child(NodeIndex(30)).terminal());
}

TEST(NodePool, clears_every_pointer_to_what_is_recycled_and_no_other) {
  std::mt19937 generator(3);
  const auto random = [&](std::uint32_t below) { return static_cast<std::uint32_t>(generator()) % below; };
  const std::uint32_t tiles = 50, bricks = 40;
  NodePool pool(exec::Device::cpu(), 2, tiles, 1);
  for (int round = 0; round < 50; ++round) {
    for (std::uint32_t i = 0; i < pool.nodes(); ++i) {
      const NodeIndex node(i);
      pool.reset_node(node, {ValueRange{0, 1}, false});
      if (random(2) == 0) pool.set_children(node, TileIndex(1 + random(tiles - 1)));  // many share
      if (random(2) == 0) pool.set_content(node, ContentWord::of_brick(BrickIndex(random(bricks))));
    }
    std::vector<ChildWord> child;
    std::vector<ContentWord> content;
    for (std::uint32_t i = 0; i < pool.nodes(); ++i) {
      child.push_back(pool.child(NodeIndex(i)));
      content.push_back(pool.content(NodeIndex(i)));
    }
    const std::vector<std::uint32_t> recycled_tiles = {1 + random(tiles - 1), 1 + random(tiles - 1)};
    const std::vector<std::uint32_t> recycled_bricks = {random(bricks), random(bricks), random(bricks)};
    pool.clear_pointers(recycled_tiles, recycled_bricks, bricks);
    const auto in = [](const std::vector<std::uint32_t>& list, std::uint32_t v) {
      return std::find(list.begin(), list.end(), v) != list.end();
    };
    for (std::uint32_t i = 0; i < pool.nodes(); ++i) {
      const bool tile_gone = child[i].has_children() && in(recycled_tiles, child[i].children().value);
      ASSERT_EQ(pool.child(NodeIndex(i)).bits, tile_gone ? 0u : child[i].bits);
      const bool brick_gone =
          content[i].kind() == ContentKind::brick && in(recycled_bricks, content[i].brick().value);
      ASSERT_EQ(pool.content(NodeIndex(i)).bits, brick_gone ? 0u : content[i].bits);
    }
  }
}

}  // namespace
}  // namespace gvx::tree
