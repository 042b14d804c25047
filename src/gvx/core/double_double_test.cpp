#include "gvx/core/double_double.h"

#include <random>

#include <gtest/gtest.h>

namespace gvx {
namespace {

TEST(DoubleDouble, keeps_what_a_double_loses) {
  const DoubleDouble deep = DoubleDouble(1) + 1e-20;
  EXPECT_EQ(deep.high, 1);
  EXPECT_EQ((deep - 1).high, 1e-20);
  const DoubleDouble third = DoubleDouble(1) / 3;
  EXPECT_LT(std::abs((third * 3 - 1).high), 1e-31);
  EXPECT_LT(std::abs((third * third - DoubleDouble(1) / 9).high), 1e-32);
}

TEST(DoubleDouble, floor_looks_at_both_parts) {
  EXPECT_EQ(floor(DoubleDouble(3) - 1e-20), 2);
  EXPECT_EQ(floor(DoubleDouble(3) + 1e-20), 3);
  EXPECT_EQ(floor(DoubleDouble(-1e-20)), -1);
  EXPECT_EQ(floor(DoubleDouble(2.5) - 1e-20), 2);
}

TEST(DoubleDouble, reads_more_digits_than_a_double_holds) {
  const auto third = parse_double_double("0.3333333333333333333333333333333333");
  ASSERT_TRUE(third.has_value());
  EXPECT_LT(std::abs((*third * 3 - 1).high), 1e-31);
  EXPECT_LT(std::abs((*parse_double_double("33333333333333333333333333333333.5e-32") - *third).high), 1e-31);
  EXPECT_EQ(parse_double_double("-2.5"), -2.5);
  EXPECT_EQ(parse_double_double("1e-19"), DoubleDouble(1) / 1e19);
  for (const char* bad : {"", "-", ".", "1e", "1.2.3", "nan", "inf", "1 ", "0x1", "1e999", "1+2"}) {
    EXPECT_FALSE(parse_double_double(bad).has_value()) << bad;
  }
}

TEST(DoubleDouble, text_reads_as_the_same_number) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 10000; ++i) {
    const DoubleDouble value = DoubleDouble(unit(random)) / unit(random) * std::pow(10, 40 * unit(random));
    const auto read = parse_double_double(to_text(value));
    ASSERT_TRUE(read.has_value()) << to_text(value);
    EXPECT_LT(std::abs((*read - value).high), 1e-30 * std::abs(value.high)) << to_text(value);
  }
  for (const char* text : {"0", "0.25", "-3", "0.1", "1200", "0.333333333333333333333333333", "1e-19",
                           "1.5e-30", "123456.789", "0.00012", "9.99e+40", "100000000000000000000.000001"}) {
    std::string same = text;
    if (const auto plus = same.find('+'); plus != std::string::npos) same.erase(plus, 1);
    EXPECT_EQ(to_text(*parse_double_double(text)), same);
  }
}

}  // namespace
}  // namespace gvx
