#include "gvx/core/result.h"

#include <gtest/gtest.h>

namespace gvx {
namespace {

Result<int> half(int v) {
  if (v % 2 != 0) return Error{"odd"};
  return v / 2;
}

Result<int> quarter(int v) {
  GVX_ASSIGN(const int h, half(v));
  GVX_TRY(half(h));
  return h / 2;
}

TEST(Result, carries_values_and_errors) {
  EXPECT_EQ(quarter(12).value(), 3);
  EXPECT_EQ(quarter(3).error().message, "odd");
  EXPECT_EQ(quarter(6).error().message, "odd");
}

TEST(ResultDeathTest, value_of_an_error_aborts) {
  EXPECT_DEATH((void)half(1).value(), "internal error");
}

}  // namespace
}  // namespace gvx
