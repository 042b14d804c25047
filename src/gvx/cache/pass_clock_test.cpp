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

TEST(PassClock, who_has_not_marched_for_long_counts_no_more) {
  PassClock clock;
  const auto idle = clock.add(), busy = clock.add();
  EXPECT_EQ(clock.begin(idle), 1u);
  std::uint32_t last = 0;
  for (std::uint32_t i = 0; i < PassClock::kPatience; ++i) last = clock.begin(busy);
  EXPECT_EQ(clock.in_use_since(), 1u);
  last = clock.begin(busy);
  EXPECT_EQ(clock.in_use_since(), last);
  EXPECT_EQ(clock.begin(idle), last + 1);
  EXPECT_EQ(clock.in_use_since(), last);
}

}  // namespace
}  // namespace gvx::cache
