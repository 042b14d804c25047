#include "gvx/cache/usage_list.h"

#include <algorithm>
#include <list>
#include <random>

#include <gtest/gtest.h>

namespace gvx::cache {
namespace {

TEST(UsageList, gives_away_the_least_recently_used) {
  UsageList list(exec::Device::cpu(), 5);
  for (const std::uint32_t slot : {0u, 1u, 2u, 4u}) list.view().touch(slot, 1);
  list.order_by_use(1);
  EXPECT_EQ(list.unused_since(1), 1u);
  list.view().touch(0, 2);
  list.order_by_use(2);
  EXPECT_EQ(list.unused_since(2), 4u);
  EXPECT_EQ(list.unused_since(1), 1u);
  EXPECT_EQ(list.unused_since(3), 5u);
  EXPECT_EQ(list.take_oldest(3), (std::vector<std::uint32_t>{3, 1, 2}));
  EXPECT_EQ(list.take_oldest(2), (std::vector<std::uint32_t>{4, 0}));
}

TEST(UsageList, agrees_with_a_list_that_is_kept_by_hand) {
  std::mt19937 generator(7);
  const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
  const std::uint32_t slots = 97;
  UsageList list(exec::Device::cpu(), slots);
  std::vector<std::uint32_t> model(slots), stamps(slots);
  for (std::uint32_t i = 0; i < slots; ++i) model[i] = i;
  for (std::uint32_t pass = 1; pass < 500; ++pass) {
    std::vector<bool> used(slots);
    for (std::uint32_t i = random() % slots; i > 0; --i) {
      const std::uint32_t slot = random() % slots;
      used[slot] = true;
      list.view().touch(slot, pass);
      stamps[slot] = pass;
    }
    const auto middle =
        std::stable_partition(model.begin(), model.end(), [&](auto slot) { return !used[slot]; });
    list.order_by_use(pass);
    ASSERT_EQ(list.unused_since(pass), static_cast<std::uint32_t>(middle - model.begin()));
    const std::uint32_t since = random() % (pass + 2);
    ASSERT_EQ(list.unused_since(since),
              static_cast<std::uint32_t>(
                  std::count_if(stamps.begin(), stamps.end(), [&](auto stamp) { return stamp < since; })));
    const std::uint32_t count = random() % (slots + 1);
    ASSERT_EQ(list.take_oldest(count), std::vector<std::uint32_t>(model.begin(), model.begin() + count));
    for (std::uint32_t i = 0; i < count; ++i) stamps[model[i]] = pass;
    std::rotate(model.begin(), model.begin() + count, model.end());
    ASSERT_TRUE(std::equal(model.begin(), model.end(), list.order().begin(), list.order().end()));
  }
}

}  // namespace
}  // namespace gvx::cache
