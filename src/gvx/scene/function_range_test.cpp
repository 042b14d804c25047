#include "gvx/scene/function_range.h"

#include <gtest/gtest.h>

namespace gvx::scene {
namespace {

TransferFunction tent() {
  return {{{0, {0, 0, 0}}, {100, {1, 0.5, 0.25}}}, {{-100, 0}, {0, 0.4}, {100, 0}}, 3, {{0, 0}, {5, 1}}};
}

TEST(FunctionRange, a_window_is_level_and_width) {
  EXPECT_EQ((ValueWindow{40, 400}.span()), (ValueSpan{-160, 240}));
}

TEST(FunctionRange, a_stretched_function_keeps_its_proportions) {
  const TransferFunction f = stretched(tent(), {10, 30});
  EXPECT_EQ(f.opacities, (std::vector<OpacityPoint>{{10, 0}, {20, 0.4}, {30, 0}}));
  EXPECT_EQ(f.colors, (std::vector<ColorPoint>{{20, {0, 0, 0}}, {30, {1, 0.5, 0.25}}}));
  EXPECT_EQ(f.unit_distance, 3);
  EXPECT_EQ(f.gradients, tent().gradients);
}

TEST(FunctionRange, a_function_of_one_value_moves) {
  const TransferFunction f = stretched({{{7, {1, 1, 1}}}, {{7, 0}, {7, 1}}}, {10, 30});
  EXPECT_EQ(f.opacity(9.9), 0);
  EXPECT_EQ(f.opacity(10), 1);
}

TEST(FunctionRange, opacities_are_multiplied_and_held_at_1) {
  EXPECT_DOUBLE_EQ(with_opacity_factor(tent(), 0.5).opacity(0), 0.2);
  const TransferFunction f = with_opacity_factor(tent(), 5);
  for (double value = -100; value <= 100; value += 3.7) {
    EXPECT_NEAR(f.opacity(value), std::min(1.0, 5 * tent().opacity(value)), 1e-12) << value;
  }
  EXPECT_TRUE(check(f).ok());
  EXPECT_TRUE(with_opacity_factor(tent(), 0).transparent(-1e9, 1e9));
}

TEST(FunctionRange, steps_stay_steps) {
  const TransferFunction f = with_opacity_factor({{{0, {}}}, {{0, 0}, {5, 0}, {5, 0.5}}}, 4);
  EXPECT_EQ(f.opacity(4.999), 0);
  EXPECT_EQ(f.opacity(5), 1);
  EXPECT_TRUE(check(f).ok());
}

}  // namespace
}  // namespace gvx::scene
