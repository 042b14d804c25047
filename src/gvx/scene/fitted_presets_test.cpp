#include "gvx/scene/fitted_presets.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "gvx/scene/transfer_presets.h"
#include "gvx/scene/value_samples_test_support.h"

namespace gvx::scene {
namespace {

/// The share of these values that a function shows at all.
double share_seen(const TransferFunction& function, const Samples& samples) {
  const auto& values = samples.values();
  const auto seen =
      std::count_if(values.begin(), values.end(), [&](double value) { return function.opacity(value) > 0; });
  return double(seen) / double(values.size());
}

TEST(FittedPresets, noise_of_the_background_is_not_seen_and_the_object_is) {
  Samples noise, object, all;
  for (Samples* s : {&noise, &all}) s->add_rayleigh(80000, 40);
  for (Samples* s : {&object, &all}) s->add_normal(20000, 600, 80);
  const ValueStatistics s = all.statistics();
  EXPECT_EQ(suggest_preset(s), "surface");
  for (const TransferFunction& f : {surface_function(s), mr_function(s)}) {
    EXPECT_LT(share_seen(f, noise), 1e-3);
    EXPECT_GT(share_seen(f, object), 0.999);
    EXPECT_GT(f.opacity(600), 0.1);
  }
}

TEST(FittedPresets, a_background_above_the_least_value_is_not_seen) {
  Samples all, background;
  for (Samples* s : {&background, &all}) s->add_normal(60000, 24000, 250);
  all.add_normal(30000, 31500, 400);
  all.add(-1000, 3);
  const TransferFunction f = surface_function(all.statistics());
  EXPECT_LT(share_seen(f, background), 1e-3);
  EXPECT_GT(f.opacity(31500), 0.1);
}

TEST(FittedPresets, bright_outliers_do_not_darken_the_object) {
  Samples plain;
  plain.add(0, 50000);
  plain.add_normal(50000, 100, 10);
  Samples bright = plain;
  bright.add(1000, 20);
  const TransferFunction a = surface_function(plain.statistics()), b = surface_function(bright.statistics());
  EXPECT_NEAR(a.opacity(100), b.opacity(100), 0.05);
  EXPECT_NEAR(a.color(100).x, b.color(100).x, 0.02);
}

TEST(FittedPresets, fields_without_a_border_have_layers_that_share_the_voxels) {
  Samples field;
  for (int i = 0; i < 100000; ++i) field.add(std::exp(-8.0 * i / 100000));
  ValueStatistics s = field.statistics();
  s.size_world = 128;
  ASSERT_EQ(suggest_preset(s), "layers");
  const TransferFunction f = layers_function(s);
  // Colours part the voxels that are seen, not the range of their values.
  const double seen = share_seen(f, field);
  EXPECT_NEAR(f.unit_distance, 128 * std::cbrt(seen) / 48, 0.05);
  EXPECT_GT(seen, 0.2);
  for (std::size_t i = 1; i + 1 < f.colors.size(); ++i) {
    const auto& values = field.values();
    const auto between = std::count_if(values.begin(), values.end(), [&](double v) {
      return v > f.colors[i - 1].value && v <= f.colors[i].value;
    });
    EXPECT_GT(double(between) / double(values.size()), 0.1 * seen) << i;
  }
}

TEST(FittedPresets, values_around_zero_diverge_and_zero_is_transparent) {
  Samples map;
  map.add(0, 60000);
  map.add_normal(38000, 0, 1);
  map.add_normal(1200, 8, 1);
  map.add_normal(800, -6, 1);
  const ValueStatistics s = map.statistics();
  EXPECT_EQ(suggest_preset(s), "diverging");
  const TransferFunction f = diverging_function(s);
  EXPECT_TRUE(f.transparent(-2, 2));
  EXPECT_LT(share_seen(f, map), 0.03);
  EXPECT_GT(f.opacity(8), 0.2);
  EXPECT_DOUBLE_EQ(f.opacity(-6), f.opacity(6));
  EXPECT_GT(f.color(5).x, f.color(5).z);
  EXPECT_LT(f.color(-5).x, f.color(-5).z);
}

TEST(FittedPresets, scans_with_negative_values_are_not_around_zero) {
  Samples head;
  head.add_normal(60000, -1000, 15);
  head.add_normal(30000, 40, 30);
  head.add_normal(10000, 900, 300);
  EXPECT_FALSE(is_around_zero(head.statistics()));
  EXPECT_EQ(suggest_preset(head.statistics()), "ct-bone");
  Samples shifted;  // never below zero but for noise
  shifted.add_normal(60000, 0, 1);
  shifted.add_normal(30000, 100, 10);
  EXPECT_FALSE(is_around_zero(shifted.statistics()));
}

TEST(FittedPresets, channels_of_different_scales_have_their_own_ranges) {
  for (const double scale : {1.0, 250.0}) {
    Samples channel;
    channel.add_normal(90000, 10 * scale, scale);
    channel.add_normal(10000, 60 * scale, 10 * scale);
    ValueStatistics s = channel.statistics();
    s.channels = 2;
    EXPECT_EQ(suggest_preset(s), "microscopy");
    const TransferFunction f = microscopy_function(s);
    EXPECT_EQ(f.opacity(13 * scale), 0);
    EXPECT_GT(f.opacity(60 * scale), 0.02);
  }
}

}  // namespace
}  // namespace gvx::scene
