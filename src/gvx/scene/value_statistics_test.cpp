#include "gvx/scene/value_statistics.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "gvx/scene/value_samples_test_support.h"

namespace gvx::scene {
namespace {

TEST(ValueStatistics, percentiles_are_linear_within_a_bin) {
  const ValueStatistics s{-10, 30, {10, 0, 30, 0}};
  EXPECT_DOUBLE_EQ(s.percentile(0), -10);
  EXPECT_DOUBLE_EQ(s.percentile(0.125), -5);
  EXPECT_DOUBLE_EQ(s.percentile(0.25), 0);
  EXPECT_DOUBLE_EQ(s.percentile(0.625), 15);
  EXPECT_DOUBLE_EQ(s.percentile(1), 20);
  EXPECT_DOUBLE_EQ(percentile_above(s, 10, 0.5), 15);
  EXPECT_DOUBLE_EQ(percentile_above(s, 25, 0.5), 30);
}

TEST(ValueStatistics, without_a_histogram_percentiles_are_shares_of_the_range) {
  EXPECT_DOUBLE_EQ((ValueStatistics{-10, 30, {}}.percentile(0.25)), 0);
  EXPECT_DOUBLE_EQ((ValueStatistics{-10, 30, {0, 0}}.percentile(1)), 30);
}

TEST(ValueStatistics, of_negative_scales_run_upwards) {
  const ValueStatistics s = physical_statistics({0, 10}, {5, 1}, -2, 3);
  EXPECT_EQ(s.minimum, -17);
  EXPECT_EQ(s.maximum, 3);
  EXPECT_EQ(s.histogram, (std::vector<std::uint64_t>{1, 5}));
}

TEST(HistogramShape, two_groups_are_parted_whatever_the_outliers) {
  Samples samples;
  samples.add_normal(70000, 100, 10);
  samples.add_normal(30000, 400, 30);
  const HistogramShape plain = histogram_shape(samples.statistics());
  EXPECT_GT(plain.threshold, 140);
  EXPECT_LT(plain.threshold, 310);
  EXPECT_GT(plain.separation, 0.95);
  EXPECT_NEAR(plain.background, 100, 8);
  EXPECT_NEAR(plain.noise_top, 140, 8);
  EXPECT_NEAR(plain.top, 485, 20);
  samples.add_normal(20, 3000, 100);
  samples.add_normal(20, -2500, 100);
  const HistogramShape wide = histogram_shape(samples.statistics());
  EXPECT_NEAR(wide.threshold, plain.threshold, 30);
  EXPECT_NEAR(wide.background, plain.background, 10);
  EXPECT_NEAR(wide.noise_top, plain.noise_top, 10);
  EXPECT_NEAR(wide.top, plain.top, 20);
}

TEST(HistogramShape, the_middle_of_an_empty_valley_is_the_threshold) {
  ValueStatistics s{0, 100, std::vector<std::uint64_t>(100)};
  s.histogram[0] = 500;
  s.histogram[80] = s.histogram[90] = 100;
  const HistogramShape shape = histogram_shape(s);
  EXPECT_NEAR(shape.threshold, 40, 1);
  EXPECT_NEAR(shape.background, 0.5, 0.5);
}

TEST(HistogramShape, of_any_histogram_is_finite) {
  for (const ValueStatistics& s :
       {ValueStatistics{0, 0, {0}}, ValueStatistics{3, 3, {0, 7}}, ValueStatistics{-3e38, 3e38, {1, 0, 1}},
        ValueStatistics{0, 1e-300, {1, 2, 3}}, ValueStatistics{0, 1, {0, 0, 0}},
        ValueStatistics{0, 1, {9}}}) {
    const HistogramShape shape = histogram_shape(s);
    for (const double value :
         {shape.threshold, shape.separation, shape.background, shape.noise_top, shape.top}) {
      EXPECT_TRUE(std::isfinite(value));
    }
    EXPECT_GE(shape.separation, 0);
    EXPECT_LE(shape.separation, 1);
  }
}

}  // namespace
}  // namespace gvx::scene
