#include "gvx/render/leaf_table.h"

#include <memory>

#include <gtest/gtest.h>

namespace gvx::render {
namespace {

/// The node of `node_level` at a cell, for steps of `level` in a tree of N = 2.
Leaf leaf_of(int level, int node_level, Cell node) {
  Leaf leaf;
  leaf.level = leaf.step_level = level;
  leaf.place.kind = Place::transparent;
  leaf.place.level = node_level;
  leaf.place.across = 1 << node_level;
  leaf.place.cell = {double(node.x), double(node.y), double(node.z)};
  const std::int32_t cells = 1 << (level - node_level);
  leaf.low = {node.x * cells, node.y * cells, node.z * cells};
  leaf.high = {leaf.low.x + cells, leaf.low.y + cells, leaf.low.z + cells};
  return leaf;
}

TEST(LeafTable, finds_coarse_leaves_by_any_number_of_fine_cells) {
  constexpr int kLevel = 12;
  const auto table = std::make_unique<LeafTable>();
  table->clear();
  EXPECT_EQ(table->find(kLevel, false, {0, 0, 0}, 2), LeafTable::kNone);
  const std::uint32_t left = table->add(leaf_of(kLevel, 1, {0, 0, 0}), 1, true);
  const std::uint32_t right = table->add(leaf_of(kLevel, 1, {1, 0, 0}), 1, true);
  const std::uint32_t fine = table->add(leaf_of(kLevel, kLevel, {5, 3000, 7}), 1, true);
  for (std::int32_t i = 0; i < 20000; ++i) {
    const Cell cell{i % 2048, i / 16, i % 17};
    ASSERT_EQ(table->find(kLevel, false, cell, 2), left);
    ASSERT_EQ(table->find(kLevel, false, {cell.x + 2048, cell.y, cell.z}, 2), right);
  }
  EXPECT_EQ(table->find(kLevel, false, {5, 3000, 7}, 2), fine);
  EXPECT_EQ(table->find(kLevel, false, {5, 3000, 8}, 2), LeafTable::kNone);
  EXPECT_EQ(table->find(kLevel, true, {5, 3000, 7}, 2), LeafTable::kNone);
  EXPECT_EQ(table->find(kLevel - 1, false, {5, 3000, 7}, 2), LeafTable::kNone);
}

TEST(LeafTable, keeps_leaves_that_rays_wait_for) {
  const auto table = std::make_unique<LeafTable>();
  table->clear();
  for (std::int32_t i = 0; i < 1024; ++i) {
    ASSERT_TRUE(table->has_room_for(1));
    const std::uint32_t index = table->add(leaf_of(10, 10, {i, 2, 3}), 1, true);
    if (i % 100 == 7) table->wait(index, static_cast<std::uint32_t>(i / 100), 2000 - i);
  }
  EXPECT_FALSE(table->has_room_for(1));
  table->forget_idle();
  EXPECT_TRUE(table->has_room_for(1000));
  EXPECT_EQ(table->find(10, false, {8, 2, 3}, 2), LeafTable::kNone);
  for (std::int32_t i = 1007; i > 0; i -= 100) {  // the nearest first
    const std::uint32_t nearest = table->nearest();
    ASSERT_EQ(nearest, table->find(10, false, {i, 2, 3}, 2));
    EXPECT_EQ(table->faces().face[0][nearest], i / 1024.0);
    RayList list;
    table->release(nearest, list);
    ASSERT_EQ(list.size, 1u);
    EXPECT_EQ(list.ray[0], i / 100);
  }
  EXPECT_EQ(table->nearest(), LeafTable::kNone);
}

}  // namespace
}  // namespace gvx::render
