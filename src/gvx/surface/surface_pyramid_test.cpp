#include "gvx/surface/surface_pyramid.h"

#include <algorithm>
#include <map>
#include <random>
#include <tuple>

#include <gtest/gtest.h>

namespace gvx::surface {
namespace {

std::tuple<std::uint32_t, std::uint64_t, std::uint64_t, std::uint64_t> tied(const NodeKey& key) {
  return {key.level, key.x, key.y, key.z};
}

/// The place of a node in the tree's order, bit by bit.
std::uint64_t morton(const NodeKey& key) {
  std::uint64_t order = 0;
  for (int bit = 20; bit >= 0; --bit)
    order = order << 3 | (key.z >> bit & 1) << 2 | (key.y >> bit & 1) << 1 | (key.x >> bit & 1);
  return order;
}

TEST(SurfacePyramid, the_trees_order_is_that_of_interleaved_bits) {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t most = std::uint64_t{1} << (1 + random() % 18);
    const NodeKey a{18, random() % most, random() % most, random() % most};
    const NodeKey b{18, i % 3 == 0 ? a.x : random() % most, i % 5 == 0 ? a.y : random() % most,
                    random() % most};
    ASSERT_EQ(before_in_tree(a, b), morton(a) < morton(b));
  }
}

/// Cells of a level by their places in the whole.
using Places = std::map<std::tuple<std::uint64_t, std::uint64_t, std::uint64_t>, int>;

Places places_of(const NodeKey& key, const CellSet& cells) {
  Places places;
  for (int z = 0; z < kCells; ++z) {
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) {
        const auto at = [](std::uint64_t brick, int cell) {
          return brick * kCells + static_cast<std::uint64_t>(cell);
        };
        if (cells.has({x, y, z})) places[{at(key.x, x), at(key.y, y), at(key.z, z)}] = 1;
      }
    }
  }
  return places;
}

TEST(SurfacePyramid, every_level_is_the_finer_one_at_half_its_places) {
  std::mt19937 random(2);
  constexpr std::uint32_t kFinest = 4;
  std::vector<NodeKey> keys;
  for (std::uint64_t i = 0; i < 16 * 16 * 16; ++i) {
    if (random() % 12 == 0) keys.push_back({kFinest, i % 16, i / 16 % 16, i / 256});
  }
  std::sort(keys.begin(), keys.end(), before_in_tree);
  std::vector<Places> levels(kFinest + 1);
  std::map<std::tuple<std::uint32_t, std::uint64_t, std::uint64_t, std::uint64_t>, std::uint8_t> made;
  SurfacePyramid pyramid(kFinest, [&](const SurfacePyramid::Made& brick) -> Status {
    EXPECT_TRUE(made.emplace(tied(brick.key), brick.children).second) << "made once";
    for (int octant = 0; octant < 8; ++octant) {
      const bool there = brick.key.level < kFinest && made.contains(tied(child(brick.key, 2, octant)));
      EXPECT_EQ(there, (brick.children >> octant & 1) != 0);
    }
    levels[brick.key.level].merge(places_of(brick.key, brick.samples.cells()));
    return {};
  });
  for (const NodeKey& key : keys) {
    SampledCells samples;
    for (int i = 0; i < 20; ++i) {
      samples.add(Cell(int(random() % 32), int(random() % 32), int(random() % 32)), {0, 0, 1}, {});
    }
    ASSERT_TRUE(pyramid.push(key, std::move(samples)).ok());
  }
  ASSERT_TRUE(pyramid.finish().ok());
  for (std::uint32_t level = kFinest; level > 0; --level) {
    Places coarser;
    for (const auto& [place, one] : levels[level]) {
      const auto& [x, y, z] = place;
      coarser[{x / 2, y / 2, z / 2}] = one;
    }
    EXPECT_EQ(coarser, levels[level - 1]) << level;
  }
  EXPECT_EQ(std::count_if(made.begin(), made.end(),
                          [](const auto& brick) { return std::get<0>(brick.first) == 0; }),
            1);
}

TEST(SurfacePyramid, what_is_out_of_order_and_what_cannot_be_taken_are_errors) {
  SampledCells one;
  one.add({1, 2, 3}, {0, 0, 1}, {});
  int taken = 0;
  SurfacePyramid pyramid(2, [&](const SurfacePyramid::Made&) -> Status {
    if (++taken > 2) return Error{"disk full"};
    return {};
  });
  ASSERT_TRUE(pyramid.push({2, 1, 0, 0}, one).ok());
  EXPECT_FALSE(pyramid.push({2, 1, 0, 0}, one).ok());
  EXPECT_FALSE(pyramid.push({2, 0, 0, 0}, one).ok());
  EXPECT_FALSE(pyramid.push({1, 1, 1, 1}, one).ok());
  ASSERT_TRUE(pyramid.push({2, 0, 1, 0}, SampledCells()).ok());
  ASSERT_TRUE(pyramid.push({2, 3, 3, 3}, one).ok());
  EXPECT_EQ(taken, 2) << "the brick and its parent";
  EXPECT_EQ(pyramid.finish().error().message, "disk full");
}

}  // namespace
}  // namespace gvx::surface
