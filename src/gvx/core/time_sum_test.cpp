#include "gvx/core/time_sum.h"

#include <thread>

#include <gtest/gtest.h>

namespace gvx {
namespace {

TEST(TimeSum, adds_what_threads_spend) {
  using namespace std::chrono_literals;
  TimeSum sum;
  EXPECT_EQ(sum.total(), 0ns);
  const auto sleep = [&] {
    const TimeSum::Span span(sum);
    std::this_thread::sleep_for(2ms);
  };
  std::thread other(sleep);
  sleep();
  other.join();
  EXPECT_GE(sum.milliseconds(), 4);
  const auto before = sum.total();
  sleep();
  EXPECT_GE(sum.total() - before, 2ms);
}

}  // namespace
}  // namespace gvx
