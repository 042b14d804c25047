#include "gvx/render/frame/level_views.h"

#include <random>

#include <gtest/gtest.h>

#include "gvx/core/node_key.h"

namespace gvx::render {
namespace {

constexpr Box3d kCube{{0, 0, 0}, {1, 1, 1}};

TEST(LevelViews, faces_are_where_they_are) {
  for (const int n : {2, 3}) {
    const Vec3dd eye(DoubleDouble(0.3), DoubleDouble(1.7), DoubleDouble(-0.2));
    const auto levels = level_views(n, 10, eye, kCube);
    for (std::uint32_t l = 0; l <= 10; ++l) {
      const double across = nodes_across(n, l);
      EXPECT_NEAR(levels[l].across, across, across * 1e-15);
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(levels[l].face(axis, levels[l].first[axis]), (DoubleDouble(0) - eye[axis]).high, 1e-15);
        EXPECT_NEAR(levels[l].face(axis, levels[l].last[axis] + 1), (DoubleDouble(1) - eye[axis]).high,
                    1e-15);
        EXPECT_EQ(levels[l].last[axis] - levels[l].first[axis] + 1, across);
      }
    }
  }
}

TEST(LevelViews, levels_agree_on_shared_faces_to_the_last_bit) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-0.5, 1.5);
  std::int64_t tested = 0;
  for (const int n : {2, 3}) {
    for (int trial = 0; trial < 300; ++trial) {
      const Vec3dd eye(Vec3d(unit(random), unit(random), unit(random)));
      const auto levels = level_views(n, 12, eye, kCube);
      for (std::size_t l = 0; l < 12; ++l) {
        for (double cell = -5; cell <= 5; ++cell) {
          // Where whole cubes meet the exact value may be half way between two doubles.
          const double place = levels[l].face(0, cell) + eye.x.high;
          if (std::abs(place - std::rint(place)) < 1e-9) continue;
          const double child = cell * n - levels[l + 1].digit.x;
          EXPECT_EQ(levels[l].face(0, cell), levels[l + 1].face(0, child));
          ++tested;
        }
      }
    }
  }
  EXPECT_GT(tested, 60000);
}

TEST(LevelViews, keep_their_digits_40_levels_down) {
  // A hair below the plane x = 1/3: in another child of the root than what is a hair above.
  const DoubleDouble hair = 1e-19, third = DoubleDouble(1) / 3;
  const auto levels = level_views(3, 40, Vec3dd(third - hair, 0.5, 0.5), kCube);
  EXPECT_EQ(levels[1].digit.x, 0);
  for (std::size_t l = 1; l <= 40; ++l) {
    EXPECT_EQ(levels[l].digit.y, 1) << l;
    // The plane is the face of some node of every level.
    const double cell = levels[l].cell_at(0, hair.high + 0.5 * levels[l].edge_high);
    EXPECT_NEAR(levels[l].face(0, cell), hair.high, 1e-6 * hair.high) << l;
    EXPECT_EQ(levels[l].parent(Vec3d(cell, 0, 0), 3).x,
              levels[l - 1].cell_at(0, hair.high + 0.5 * levels[l].edge_high));
    if (l < 20) continue;  // rays sample finer nodes than these so near to the eye
    EXPECT_EQ(levels[l].cell_at(0, hair.high * (1 + 1e-5)), cell) << l;
    EXPECT_EQ(levels[l].cell_at(0, hair.high * (1 - 1e-5)), cell - 1) << l;
  }
  std::uint64_t across = 1;
  for (int l = 0; l < 40; ++l) across *= 3;
  EXPECT_EQ(levels[40].eye.y, across / 2);
}

TEST(LevelViews, name_the_nodes_of_the_visible_box) {
  const auto levels = level_views(2, 4, Vec3dd(0.6, 0.6, -3.1), {{0.25, 0.3, 0}, {0.5, 0.7, 1}});
  EXPECT_EQ(levels[2].first.x + 2, 1);
  EXPECT_EQ(levels[2].last.x + 2, 1);  // 0.5 itself is in the node above
  EXPECT_EQ(levels[2].first.y + 2, 1);
  EXPECT_EQ(levels[2].last.y + 2, 2);
  EXPECT_EQ(levels[0].first.z, 4);
  EXPECT_EQ(levels[4].first.z, 50);
  EXPECT_EQ(levels[4].last.z, 65);
}

}  // namespace
}  // namespace gvx::render
