// Bounds that are estimated hold what the function really is, for functions like those that users write.

#include "gvx/produce/sampled_bounds.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "gvx/produce/field_producer.h"

namespace gvx::produce {
namespace {

float gyroid(Vec3d p) {
  const double k = 8 * M_PI;
  return static_cast<float>(std::sin(k * p.x) * std::cos(k * p.y) + std::sin(k * p.y) * std::cos(k * p.z) +
                            std::sin(k * p.z) * std::cos(k * p.x));
}
float distance_to_ball(Vec3d p) {
  return static_cast<float>(length(p - Vec3d(0.5)) - 0.3);
}
float slope(Vec3d p) {
  return static_cast<float>(3 * p.x - 2 * p.y + p.z);
}
float soft_ball(Vec3d p) {
  return std::fmin(std::fmax(-40 * distance_to_ball(p), 0.0f), 1.0f);
}

/// A box of the sizes that nodes of levels 1 to 6 have, anywhere in the cube and as far beyond as a rim
/// reaches.
template <typename Random>
Box3d random_box(Random& random) {
  std::uniform_real_distribution<double> inside(0, 1);
  const double edge = 1.25 * std::exp2(-1 - 5 * inside(random));
  const Vec3d low = Vec3d(inside(random), inside(random), inside(random)) - Vec3d(edge / 2);
  return intersect({low, low + Vec3d(edge)}, {Vec3d(-0.25), Vec3d(1.25)});
}

TEST(SampledBounds, hold_every_value_of_smooth_functions) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0, 1);
  for (const auto& function : {gyroid, distance_to_ball, slope, soft_ball}) {
    const SampledBounds bounds = SampledBounds::create(function, {}).value();
    for (int i = 0; i < 400; ++i) {
      const Box3d box = random_box(random);
      const ValueRange range = bounds(box);
      // Corners hold the extremes of what goes one way.
      for (int p = 0; p < 300; ++p) {
        Vec3d at;
        for (int axis = 0; axis < 3; ++axis) {
          const double part = p < 8 ? p >> axis & 1 : share(random);
          at[axis] = box.minimum[axis] + part * (box.maximum[axis] - box.minimum[axis]);
        }
        ASSERT_TRUE(range.contains(function(at)))
            << i << ": " << function(at) << " beyond " << range.minimum << " to " << range.maximum;
      }
    }
  }
}

TEST(SampledBounds, are_no_wider_than_a_function_needs) {
  const SampledBounds bounds = SampledBounds::create(distance_to_ball, {}).value();
  const ValueRange at_surface = bounds({Vec3d(0.78), Vec3d(0.8)});  // 0.18 to 0.22 from the ball
  EXPECT_GT(at_surface.minimum, 0.14f);
  EXPECT_LT(at_surface.maximum, 0.25f);
}

TEST(SampledBounds, a_periodic_function_does_not_look_constant) {
  // Of this many periods all samples of an even grid would be 0.
  const auto waves = [](Vec3d p) { return static_cast<float>(std::sin(64 * M_PI * p.x)); };
  const SampledBounds bounds = SampledBounds::create(waves, {.feature = 1.0 / 8, .samples = 8}).value();
  EXPECT_LE(bounds.all().minimum, -1);
  EXPECT_GE(bounds.all().maximum, 1);
}

TEST(SampledBounds, of_one_value_are_that_value) {
  const SampledBounds bounds = SampledBounds::create(soft_ball, {}).value();
  EXPECT_EQ(bounds({Vec3d(0.0), Vec3d(0.1)}), (ValueRange{0, 0}));
  EXPECT_EQ(bounds({Vec3d(0.45), Vec3d(0.55)}), (ValueRange{1, 1}));
}

TEST(SampledBounds, large_boxes_have_the_bounds_of_all_and_none_is_wider) {
  const SampledBounds bounds =
      SampledBounds::create(gyroid, {.feature = 1.0 / 64, .all = ValueRange{-2, 2}}).value();
  EXPECT_EQ(bounds({Vec3d(0), Vec3d(1)}), (ValueRange{-2, 2}));
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const ValueRange range = bounds(random_box(random));
    EXPECT_GE(range.minimum, -2);
    EXPECT_LE(range.maximum, 2);
  }
}

TEST(SampledBounds, are_not_narrowed_below_what_was_found) {
  const SampledBounds bounds = SampledBounds::create(slope, {.all = ValueRange{0, 0.1f}}).value();
  const ValueRange range = bounds({Vec3d(0.5), Vec3d(0.51)});
  EXPECT_GE(range.maximum, 1.0f);
}

TEST(SampledBounds, what_is_no_data_is_in_no_bounds) {
  const auto half = [](Vec3d p) { return p.x < 0.5 ? NAN : static_cast<float>(p.x); };
  const SampledBounds bounds = SampledBounds::create(half, {.feature = 1.0 / 16}).value();
  const ValueRange none = bounds({Vec3d(0.1), Vec3d(0.2)}), some = bounds({Vec3d(0.45), Vec3d(0.55)});
  EXPECT_GT(none.minimum, none.maximum);
  EXPECT_GE(some.minimum, 0.4f);
  EXPECT_LE(some.maximum, 0.65f);
}

TEST(SampledBounds, serve_a_producer) {
  TreeDescription tree;
  tree.m = 8;
  tree.max_level = 4;
  const FieldProducer producer(tree, soft_ball, SampledBounds::create(soft_ball, {}).value());
  const NodeKey keys[] = {{4, 0, 0, 0}, {4, 8, 8, 8}, {4, 12, 8, 8}};
  tree::NodeInfo infos[3];
  ASSERT_TRUE(producer.describe(keys, infos).ok());
  EXPECT_EQ(infos[0].ranges.channel[0], (ValueRange{0, 0}));
  EXPECT_EQ(infos[1].ranges.channel[0], (ValueRange{1, 1}));
  EXPECT_FALSE(infos[2].ranges.constant());  // the surface is there
}

}  // namespace
}  // namespace gvx::produce
