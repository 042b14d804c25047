#include "gvx/scene/label_table.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace gvx::scene {
namespace {

TEST(LabelColors, are_apart_and_0_is_transparent) {
  const TransferFunction f = label_colors(300);
  EXPECT_TRUE(check(f).ok());
  EXPECT_EQ(f.opacity(0), 0);
  for (std::uint32_t a = 1; a < 300; ++a) {
    EXPECT_EQ(f.opacity(a), f.opacity(1));
    // Those whose numbers are near each other are often neighbours.
    for (std::uint32_t b = a + 1; b < std::min(a + 8, 300u); ++b) {
      EXPECT_GT(length(f.color(a) - f.color(b)), 0.15) << a << ' ' << b;
    }
  }
}

TEST(LabelColors, of_a_table_take_the_place_of_their_own) {
  LabelTable table;
  table[0] = {"outside", Vec3d(1, 1, 1), 1};
  table[2] = {"two", Vec3d(0.25, 0.5, 0.75), 1};
  table[3] = {"named only"};
  table[4] = {"hidden", Vec3d(1, 0, 0), 0};
  table[900] = {"not there", Vec3d(1, 0, 0), 1};
  const TransferFunction own = label_colors(6), f = label_colors(6, table);
  EXPECT_TRUE(check(f).ok());
  EXPECT_EQ(f.opacity(0), 0);
  EXPECT_EQ(f.color(2), Vec3d(0.25, 0.5, 0.75));
  EXPECT_EQ(f.color(3), own.color(3));
  EXPECT_EQ(f.opacity(3), own.opacity(3));
  EXPECT_EQ(f.opacity(4), 0);
  EXPECT_EQ(f.color(5), own.color(5));
}

TEST(LabelColors, of_a_volume_of_nothing_are_sound) {
  EXPECT_TRUE(check(label_colors(0)).ok());
  EXPECT_TRUE(check(label_colors(1, {{1, {"one", Vec3d(1, 0, 0), 1}}})).ok());
}

}  // namespace
}  // namespace gvx::scene
