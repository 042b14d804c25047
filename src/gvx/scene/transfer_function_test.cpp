#include "gvx/scene/transfer_function.h"

#include <cmath>

#include <gtest/gtest.h>

#include "gvx/scene/label_table.h"
#include "gvx/scene/transfer_limits.h"
#include "gvx/scene/transfer_presets.h"

namespace gvx::scene {
namespace {

TransferFunction tent() {
  return {
      {{0, {0, 0, 0}}, {100, {1, 0.5, 0.25}}}, {{-50, 0}, {10, 0}, {20, 0.5}, {30, 0}, {80, 0}, {80, 1}}, 0};
}

TEST(TransferFunction, is_piecewise_linear_with_steps_and_constant_beyond) {
  const TransferFunction f = tent();
  EXPECT_DOUBLE_EQ(f.opacity(15), 0.25);
  EXPECT_DOUBLE_EQ(f.opacity(79.999), 0);
  EXPECT_DOUBLE_EQ(f.opacity(80), 1);
  EXPECT_DOUBLE_EQ(f.opacity(-1e9), 0);
  EXPECT_DOUBLE_EQ(f.opacity(1e9), 1);
  EXPECT_DOUBLE_EQ(f.color(50).y, 0.25);
}

TEST(TransferFunction, is_built_up_point_by_point) {
  const TransferFunction built = TransferFunction()
                                     .add_color(100, {1, 0.5, 0.25})
                                     .add_color(0, {0, 0, 0})
                                     .add_opacity(80, 0)
                                     .add_opacity(80, 1)
                                     .add_opacity(10, 0)
                                     .add_opacity(-50, 0)
                                     .add_opacity(30, 0)
                                     .add_opacity(20, 0.5);
  EXPECT_EQ(built, tent());
  const TransferFunction edges = tent().add_gradient(5, 1).add_gradient(0, 0).set_unit_distance(3);
  EXPECT_EQ(edges.unit_distance, 3);
  EXPECT_DOUBLE_EQ(edges.gradient_factor(1), 0.2);
  EXPECT_TRUE(check(edges).ok());
}

TEST(TransferFunction, transparent_is_about_the_whole_range) {
  const TransferFunction f = tent();
  EXPECT_TRUE(f.transparent(-100, 10));
  EXPECT_FALSE(f.transparent(0, 50));
  EXPECT_TRUE(f.transparent(30, 79));
  EXPECT_FALSE(f.transparent(40, 80));
}

TEST(TransferTable, agrees_with_the_function_between_its_entries) {
  const TransferFunction f = tent();
  const double scale = 0.5, offset = -20;
  const TransferTable table = bake(f, scale, offset, 16);
  const TransferView view = table.view();
  for (double physical = -60; physical < 100; physical += 0.37) {
    if (std::abs(physical - 80) < 0.1) continue;  // the step is as wide as one entry
    const Matter m = view.at(view.entry_of(static_cast<float>((physical - offset) / scale)));
    const double opacity = f.opacity(physical);
    EXPECT_NEAR(1 - std::exp(-m.extinction), opacity, 2e-3);
    if (m.extinction > 0.01f) {
      EXPECT_NEAR(m.color.x / m.extinction, f.color(physical).x, 1e-3);
    }
  }
}

TEST(TransferTable, points_that_it_cannot_tell_apart_are_named) {
  const std::vector<ColorPoint> colors = {{0, {1, 1, 1}}};
  const TransferFunction both = {colors, {{0, 0}, {1, 0.5}, {1 + 1e-3, 0}, {5e8, 0.1}, {1e9, 0}}, 0};
  const auto close = points_too_close(both, {0, 1e9});
  ASSERT_TRUE(close);
  EXPECT_EQ(*close, std::pair(1.0, 1 + 1e-3));
  EXPECT_FALSE(points_too_close(both, {0, 2}));
  EXPECT_FALSE(points_too_close(tent(), {}));
  // Of what is the same beyond some value only that value counts.
  EXPECT_FALSE(points_too_close({colors, {{0, 0}, {1, 0.5}, {1 + 1e-3, 0}, {1e9, 0}}, 0}, {0, 1e9}));
}

TEST(TransferTable, below_a_step_at_the_first_point_is_what_the_first_point_says) {
  for (const double step : {5.0, 0.0, -1e6}) {
    for (const std::vector<OpacityPoint>& opacities :
         {std::vector<OpacityPoint>{{step, 0}, {step, 0.9}},
          std::vector<OpacityPoint>{{step, 0}, {step, 0.9}, {step + 5, 0.5}}}) {
      for (const ValueSpan values : {ValueSpan{}, ValueSpan{step - 100, step + 100}}) {
        const TransferTable table = bake({{{step, {1, 1, 1}}}, opacities, 0}, 1, 0, 16, values);
        const TransferView view = table.view();
        EXPECT_EQ(view.at(view.entry_of(static_cast<float>(step - 3))).extinction, 0.0f) << step;
        EXPECT_GT(view.at(view.entry_of(static_cast<float>(step + 3))).extinction, 0.5f) << step;
        EXPECT_TRUE(view.transparent({static_cast<float>(step - 50), static_cast<float>(step - 3)}));
      }
    }
  }
}

TEST(TransferTable, gradients_far_beyond_the_last_bend_change_nothing) {
  TransferFunction near = tent(), far = tent();
  near.gradients = {{0, 0}, {10, 1}};
  far.gradients = {{0, 0}, {10, 1}, {1e9, 1}};
  EXPECT_EQ(bake(near, 1, 0, 16).gradient_factor, bake(far, 1, 0, 16).gradient_factor);
}

TEST(TransferTable, what_is_beyond_a_transparent_end_is_transparent) {
  // Most of a scan is: air below the first point.
  const TransferFunction ramp = {{{100, {1, 1, 1}}}, {{100, 0}, {200, 1}}, 0};
  EXPECT_TRUE(bake(ramp, 1, 0, 16).view().transparent({-1000, 100}));
  EXPECT_FALSE(bake(ramp, 1, 0, 16).view().transparent({-1000, 101}));
  const TransferFunction fall = {{{100, {1, 1, 1}}}, {{100, 1}, {200, 0}}, 0};
  EXPECT_TRUE(bake(fall, 1, 0, 16).view().transparent({200, 5000}));
  EXPECT_FALSE(bake(fall, 1, 0, 16).view().transparent({199, 5000}));
}

TEST(TransferTable, labels_are_looked_up_one_by_one) {
  const TransferFunction colors = label_colors(40);
  const TransferTable table = bake_labels(colors, 1, 0, 40);
  const TransferView view = table.view();
  EXPECT_EQ(view.of_label(0).extinction, 0.0f);
  for (std::uint32_t label = 1; label < 40; ++label) {
    const Matter m = view.of_label(label);
    ASSERT_GT(m.extinction, 0.0f);
    EXPECT_NEAR(m.color.x / m.extinction, colors.color(label).x, 1e-5);
  }
  EXPECT_TRUE(view.transparent({0, 0}));
  EXPECT_FALSE(view.transparent({0, 1}));
}

TEST(TransferFunction, check_names_the_point) {
  TransferFunction f = tent();
  f.opacities[2].opacity = 1.5;
  EXPECT_NE(check(f).error().message.find("opacity point 3"), std::string::npos);
  f = tent();
  f.colors[1].value = -1;
  EXPECT_NE(check(f).error().message.find("colour point 2"), std::string::npos);
  f = tent();
  f.colors[0].value = NAN;
  EXPECT_FALSE(check(f).ok());
  EXPECT_TRUE(check(tent()).ok());
}

TEST(Presets, all_are_sound_whatever_the_statistics) {
  for (const char* name : preset_names()) {
    for (const ValueStatistics& s :
         {ValueStatistics{0, 255, {}}, ValueStatistics{-1024, 3000, {5, 4, 3, 2, 1}},
          ValueStatistics{7, 7, {0, 0}}, ValueStatistics{0, 2e-10, {9, 1}}, ValueStatistics{0, 1e-44, {}},
          ValueStatistics{1e6, 1e6 + 0.1, {9, 1}}, ValueStatistics{-3e38, 3e38, {1, 2}}}) {
      EXPECT_TRUE(check(preset(name, s).value()).ok()) << name;
    }
  }
  // What fits itself to the values does so whatever their size.
  for (const char* name :
       {"mr", "surface", "layers", "microscopy", "gray", "solid", "inside", "cloud", "ramp"}) {
    const ValueStatistics unit{0, 1, {40, 30, 20, 9, 1, 0, 0, 2}};
    const TransferFunction one = preset(name, unit).value();
    for (const double size : {1e-30, 1e-10, 1e10, 1e30}) {
      ValueStatistics sized = unit;
      sized.maximum *= size;
      const TransferFunction f = preset(name, sized).value();
      for (double v = 0.05; v < 1; v += 0.1) {
        EXPECT_NEAR(f.opacity(v * size), one.opacity(v), 1e-9) << name << ' ' << size;
        EXPECT_NEAR(f.color(v * size).x, one.color(v).x, 1e-9) << name << ' ' << size;
      }
    }
  }
  EXPECT_FALSE(preset("rainbow", {}).ok());
  EXPECT_EQ(suggest_preset({-1024, 2986, {}}), "ct-bone");
  EXPECT_EQ(suggest_preset({0, 255, {}}), "gray");
  EXPECT_EQ(suggest_preset({0, 255, {}, true}), "mr");
  EXPECT_EQ(suggest_preset({0, 255, {}, false, 0, 3}), "microscopy");
}

}  // namespace
}  // namespace gvx::scene
