#include "gvx/cache/pass_clock.h"

#include <gtest/gtest.h>

namespace gvx::cache {
namespace {

TEST(PassClock, what_the_last_pass_of_any_walker_stamped_is_in_use) {
  PassClock clock;
  const auto first = clock.add(), second = clock.add();
  EXPECT_EQ(clock.in_use_since(), 1u);
  EXPECT_EQ(clock.begin(first), 1u);
  EXPECT_EQ(clock.begin(second), 2u);
  EXPECT_EQ(clock.in_use_since(), 1u);
  EXPECT_EQ(clock.begin(second), 3u);
  EXPECT_EQ(clock.in_use_since(), 1u);
  clock.rest(first);
  EXPECT_EQ(clock.in_use_since(), 3u);
  EXPECT_EQ(clock.begin(first), 4u);
  clock.remove(second);
  EXPECT_EQ(clock.in_use_since(), 4u);
  EXPECT_EQ(clock.add(), second);
  clock.rest(first);
  EXPECT_EQ(clock.in_use_since(), 5u);
}

}  // namespace
}  // namespace gvx::cache
