#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/render/formula/one_lane.h"
#include "gvx/scene/transfer_function.h"

namespace gvx::render::one_lane {
namespace {

using scene::bake, scene::ColorPoint, scene::Matter, scene::TransferFunction, scene::TransferTable,
    scene::TransferView;

TransferFunction tent() {
  return {
      {{0, {0, 0, 0}}, {100, {1, 0.5, 0.25}}}, {{-50, 0}, {10, 0}, {20, 0.5}, {30, 0}, {80, 0}, {80, 1}}, 0};
}

/// The mean matter of the entries between two.
Matter mean_between(const TransferView& view, float from, float to) {
  const auto m = Means<false, false>(Function(view)).mean(from, to, 0, true);
  return {{m.part[0], m.part[1], m.part[2]}, m.part[3]};
}

TEST(TransferFunctionLookedUp, means_are_those_of_the_function_wherever_the_interval) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> value(-80, 120);
  for (const double scale : {1.0, 0.01, -2.0}) {
    const TransferTable table = bake(tent(), scale, 5, 16);
    const TransferView view = table.view();
    for (int i = 0; i < 2000; ++i) {
      double a = value(random), b = value(random);
      if (i % 4 == 0) b = a + 0.05 * (b - a);
      const auto entry = [&](double v) { return view.entry_of(static_cast<float>((v - 5) / scale)); };
      if (entry(a) > entry(b)) std::swap(a, b);
      double extinction = 0, green = 0;
      constexpr int kParts = 4000;
      for (int k = 0; k < kParts; ++k) {
        const double v = a + (b - a) * (k + 0.5) / kParts;
        const double e = std::min(16.0, -std::log1p(-tent().opacity(v)));
        extinction += e / kParts;
        green += e * tent().color(v).y / kParts;
      }
      const Matter m = mean_between(view, entry(a), entry(b));
      // A step of the function is placed to a quarter of an entry.
      const double tolerance = 2e-3 + 16 * 0.02 / std::max(std::abs(b - a), 0.02);
      ASSERT_NEAR(m.extinction, extinction, tolerance) << a << ' ' << b;
      ASSERT_NEAR(m.color.y, green, tolerance) << a << ' ' << b;
    }
  }
}

TEST(TransferFunctionLookedUp, even_functions_are_looked_up_half_way_but_not_across_their_ends) {
  std::mt19937 random(9);
  std::uniform_real_distribution<float> value(-60, 160);
  const TransferFunction ramp = {{{0, {1, 1, 1}}}, {{0, 0}, {100, 0.02}}, 0};
  const TransferFunction step = {{{0, {1, 1, 1}}}, {{0, 0}, {40, 0}, {44, 0.9}, {100, 0.9}}, 0};
  for (const TransferFunction& function : {ramp, step}) {
    const TransferTable table = bake(function, 1, 0, 16);
    const TransferView view = table.view();
    const double greatest = -std::log1p(-function.opacities.back().opacity);
    int even = 0;
    for (int i = 0; i < 3000; ++i) {
      const float a = value(random), b = i % 2 == 0 ? value(random) : a + 0.05f * value(random);
      even += Function(view).is_even(view.entry_of(a), view.entry_of(b)) ? 1 : 0;
      double extinction = 0;
      constexpr int kParts = 2000;
      for (int k = 0; k < kParts; ++k) {
        extinction -= std::log1p(-function.opacity(a + (double(b) - a) * (k + 0.5) / kParts)) / kParts;
      }
      ASSERT_NEAR(mean_between(view, view.entry_of(a), view.entry_of(b)).extinction, extinction,
                  3e-3 * greatest)
          << a << ' ' << b;
    }
    EXPECT_GT(even, 300);
  }
}

TEST(TransferFunctionLookedUp, wide_intervals_of_a_smooth_piece_are_looked_up_half_way_too) {
  std::mt19937 random(10);
  std::uniform_real_distribution<float> value(0, 100);
  const std::vector<ColorPoint> colors = {{0, {0.2, 0.3, 0.9}}, {100, {1, 0.9, 0.1}}};
  const TransferFunction haze = {colors, {{0, 0}, {100, 0.02}}, 0};
  const TransferFunction surface = {colors, {{0, 0}, {20, 0}, {20.1, 0.8}, {100, 0.9}}, 0};
  const TransferFunction steep = {colors, {{0, 0}, {10, 0}, {90, 0.8}, {100, 0}}, 0};
  const TransferFunction opaque = {colors, {{0, 0}, {100, 1}}, 0};
  const auto check = [&](const TransferFunction& function, double most_extinction, int least) {
    const TransferTable table = bake(function, 1, 0, most_extinction);
    const TransferView view = table.view();
    double greatest = 0;
    for (const Matter& m : table.matter) greatest = std::max(greatest, std::min(double(m.extinction), 7.0));
    int wide = 0;
    for (int i = 0; i < 4000; ++i) {
      const float share = i % 3 == 0 ? 1 : i % 3 == 1 ? 0.1f : 0.005f;
      const float a = value(random), b = a + share * (value(random) - a);
      const float from = view.entry_of(a), to = view.entry_of(b);
      if (std::fabs(to - from) <= TransferView::kNarrow) continue;
      if (!Function(view).is_in_parabola(from, to) && !Function(view).is_even(from, to)) continue;
      wide += std::fabs(to - from) > 4 * view.even.width ? 1 : 0;
      double extinction = 0, green = 0;
      constexpr int kParts = 2000;
      for (int k = 0; k < kParts; ++k) {
        const double v = a + (double(b) - a) * (k + 0.5) / kParts;
        const double e = std::min(-std::log1p(-function.opacity(v)), most_extinction);
        extinction += e / kParts;
        green += e * function.color(v).y / kParts;
      }
      const Matter m = mean_between(view, from, to);
      ASSERT_NEAR(m.extinction, extinction, 1.2e-3 * greatest) << a << ' ' << b;
      ASSERT_NEAR(m.color.y, green, 1.2e-3 * greatest) << a << ' ' << b;
    }
    EXPECT_GE(wide, least);
  };
  check(haze, 16, 500);
  check(surface, 16, 500);
  check(steep, 16, 500);
  // What is opaque anyway does not excuse errors of what is not.
  check(opaque, 16, 0);
  check(opaque, 1000, 0);
}

TEST(TransferFunctionLookedUp, a_spike_is_even_nowhere_near_and_a_constant_everywhere) {
  const TransferFunction spike = {{{0, {1, 1, 1}}}, {{0, 0}, {50, 0}, {50.02, 0.9}, {50.04, 0}, {100, 0}}, 0};
  const TransferTable uneven = bake(spike, 1, 0, 16);
  // So narrow a spike has the table for itself.
  EXPECT_LT(uneven.even.width, Function(uneven.view()).length(0, uneven.view().entry_of(50.04f)) / 256);
  EXPECT_GT(uneven.even.above, uneven.view().entry_of(50));
  EXPECT_LT(uneven.even.above, uneven.view().entry_of(51));
  EXPECT_GE(uneven.first_visible, uneven.view().entry_of(49.9f));
  EXPECT_LE(uneven.last_visible, uneven.view().entry_of(50.1f));
  const TransferTable constant = bake({{{0, {1, 1, 1}}}, {{0, 0.5}, {100, 0.5}}, 0}, 1, 0, 16);
  EXPECT_GE(constant.even.width, TransferView::kEntries / 2);
  EXPECT_LT(constant.first_visible, -1e6f);
  EXPECT_FALSE(uneven.view().hides_lowest_only());
  EXPECT_TRUE(constant.view().hides_lowest_only());
  EXPECT_TRUE(bake({{{0, {1, 1, 1}}}, {{0, 0}, {50, 0}, {100, 1}}, 0}, 1, 0, 16).view().hides_lowest_only());
  EXPECT_TRUE(bake({{{0, {1, 1, 1}}}, {{0, 0}, {100, 0}}, 0}, 1, 0, 16).view().hides_lowest_only());
  EXPECT_GT(constant.last_visible, 1e6f);
}

TEST(TransferFunctionLookedUp, small_means_survive_large_ones_below_them) {
  // Floats would lose the faint matter behind a thousand opaque entries.
  const TransferFunction f = {{{0, {1, 1, 1}}}, {{0, 1}, {500, 1}, {500, 1e-4}, {1000, 1e-4}}, 0};
  const TransferTable table = bake(f, 1, 0, 16);
  const TransferView view = table.view();
  for (float v = 510; v < 980; v += 7.3f) {
    const Matter m = mean_between(view, view.entry_of(v), view.entry_of(v + 3));
    EXPECT_NEAR(m.extinction, 1e-4, 5e-6) << v;
  }
}

/// The largest differences of what two tables say of stored values: of matter, and of means over steps.
double difference(const TransferTable& a, const TransferTable& b, double first, double last, double step) {
  const TransferView view[2] = {a.view(), b.view()};
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto from = static_cast<float>(first + (last - first) * i / 2000);
    const auto to = static_cast<float>(double(from) + step);
    Matter at[2], mean[2];
    for (int k = 0; k < 2; ++k) {
      at[k] = view[k].at(view[k].entry_of(from));
      mean[k] = mean_between(view[k], view[k].entry_of(from), view[k].entry_of(to));
    }
    most = std::max({most, std::abs(double(at[0].extinction) - double(at[1].extinction)),
                     std::abs(double(mean[0].extinction) - double(mean[1].extinction)),
                     std::abs(double(mean[0].color.x) - double(mean[1].color.x)),
                     std::abs(double(mean[0].color.z) - double(mean[1].color.z))});
  }
  return most;
}

TEST(TransferFunctionLookedUp, points_far_beyond_the_values_change_nothing) {
  const std::vector<ColorPoint> colors = {{0, {0, 0, 1}}, {2, {1, 0, 0}}};
  const TransferFunction unit = {colors, {{0, 0}, {0.5, 0}, {0.6, 0.9}, {2, 0.9}}, 0};
  const TransferFunction far_last = {colors, {{0, 0}, {0.5, 0}, {0.6, 0.9}, {1e9, 0.9}}, 0};
  const TransferFunction far_first = {colors, {{-1e12, 0}, {0.5, 0}, {0.6, 0.9}, {2, 0.9}}, 0};
  const TransferFunction far_both = {colors, {{-1e30, 0}, {0.5, 0}, {0.6, 0.9}, {1e30, 0.9}}, 0};
  TransferFunction far_colors = unit;
  far_colors.colors = {{-1e9, {0, 0, 1}}, {0, {0, 0, 1}}, {2, {1, 0, 0}}, {1e9, {1, 0, 0}}};
  for (const double scale : {1.0, 1e-3, -0.25}) {
    const double first = scale > 0 ? 0 : 2 / scale, last = scale > 0 ? 2 / scale : 0;
    const TransferTable near = bake(unit, scale, 0, 16, {0, 2});
    for (const TransferFunction& far : {far_last, far_first, far_both, far_colors}) {
      const TransferTable table = bake(far, scale, 0, 16, {0, 2});
      EXPECT_EQ(table.matter.size(), near.matter.size());
      EXPECT_NEAR(table.span, near.span, 1e-9 * near.span);
      EXPECT_LT(difference(near, table, first, last, 0.01 / scale), 1e-6) << scale;
      // Whatever the values are, the table is where the function bends.
      EXPECT_LT(difference(near, bake(far, scale, 0, 16), first, last, 0.01 / scale), 2e-2) << scale;
    }
  }
}

TEST(TransferFunctionLookedUp, a_narrow_window_in_a_wide_range_has_entries) {
  const TransferFunction window = {
      {{0, {0, 0, 0}}, {65535, {1, 1, 1}}}, {{0, 0}, {1000, 0}, {1100, 0.9}, {60000, 0.9}, {65535, 0.2}}, 0};
  const TransferTable table = bake(window, 1, 0, 16, {0, 65535});
  EXPECT_GT(table.matter.size(), std::size_t(TransferView::kEntries));
  const TransferView view = table.view();
  EXPECT_NEAR(Function(view).length(view.entry_of(0), view.entry_of(65535)), TransferView::kEntries, 2);
  for (float v = 990; v < 1110; v += 0.25f) {
    const double exact = -std::log1p(-window.opacity(double(v)));
    EXPECT_NEAR(view.at(view.entry_of(v)).extinction, exact, 0.01) << v;
    EXPECT_NEAR(mean_between(view, view.entry_of(v - 0.2f), view.entry_of(v + 0.2f)).extinction, exact, 0.1)
        << v;
  }
  EXPECT_EQ(bake(tent(), 1, 0, 16).matter.size(), std::size_t(TransferView::kEntries));
}

TEST(TransferFunctionLookedUp, values_of_any_size_have_entries) {
  for (const double size : {1e-43, 1e-38, 1e-35, 1e-30, 1e-10, 1.0, 1e10, 1e30}) {
    const TransferFunction ramp = {{{0, {0, 0, 0}}, {2 * size, {1, 1, 1}}}, {{0, 0.5}}, 0};
    const TransferTable table = bake(ramp, 1, 0, 16, {0, 2 * size});
    const TransferView view = table.view();
    for (const double part : {0.0, 0.5, 1.0, 1.7, 2.0}) {
      const Matter m = view.at(view.entry_of(static_cast<float>(part * size)));
      ASSERT_TRUE(std::isfinite(m.color.x)) << size;
      if (size >= 1e-35) {
        EXPECT_NEAR(m.color.x / m.extinction, part / 2, 1e-3) << size;
      }
    }
  }
  // A step at 0, where all relative widths are 0.
  for (const double size : {1e-30, 1.0, 1e5, 1e30}) {
    const TransferTable table = bake({{{0, {1, 1, 1}}}, {{0, 0}, {0, 0.5}}, 0}, 1, 0, 16, {-size, size});
    const TransferView view = table.view();
    const auto end = static_cast<float>(size);
    EXPECT_NEAR(mean_between(view, view.entry_of(0.5f * end), view.entry_of(end)).extinction, std::log(2.0),
                1e-5);
    EXPECT_EQ(mean_between(view, view.entry_of(-end), view.entry_of(-0.5f * end)).extinction, 0);
    EXPECT_NEAR(mean_between(view, view.entry_of(-end), view.entry_of(end)).extinction, 0.5 * std::log(2.0),
                1e-3);
  }
  // One point, and values that are one.
  for (const double value : {-3e30, -1e-30, 0.0, 7.0}) {
    const TransferTable table = bake({{{value, {1, 0.5, 0}}}, {{value, 0.5}}, 0}, 1, 0, 16, {value, value});
    EXPECT_NEAR(table.view().at(table.view().entry_of(static_cast<float>(value))).extinction, std::log(2.0),
                1e-6);
  }
}

TEST(TransferFunctionLookedUp, transparency_is_conservative) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-70, 110);
  for (const double scale : {1.0, 0.01, -2.0}) {
    const TransferTable table = bake(tent(), scale, 5, 16);
    const TransferView view = table.view();
    int transparent = 0;
    for (int i = 0; i < 20000; ++i) {
      const double a = (value(random) - 5) / scale, b = (value(random) - 5) / scale;
      const ValueRange range{static_cast<float>(std::min(a, b)), static_cast<float>(std::max(a, b))};
      if (!view.transparent(range)) continue;
      ++transparent;
      for (int k = 0; k <= 20; ++k) {
        const float stored = range.minimum + (range.maximum - range.minimum) * static_cast<float>(k) / 20;
        ASSERT_EQ(view.at(view.entry_of(stored)).extinction, 0.0f);
      }
      const float ends[2] = {view.entry_of(range.minimum), view.entry_of(range.maximum)};
      ASSERT_EQ(mean_between(view, ends[0], ends[1]).extinction, 0.0f);
    }
    EXPECT_GT(transparent, 1000);
  }
}

}  // namespace
}  // namespace gvx::render::one_lane
