#include "gvx/cache/slot_table.h"

#include <algorithm>
#include <list>
#include <map>
#include <random>

#include <gtest/gtest.h>

namespace gvx::cache {
namespace {

TEST(SlotTable, gives_away_what_was_not_used_and_then_the_oldest) {
  SlotTable<int> table(exec::Device::cpu(), 4, 1);
  EXPECT_EQ(table.room(Eviction::unused), 3u);
  const TakenSlots first = table.take(9, Eviction::unused);
  ASSERT_EQ(first.slots, (std::vector<std::uint32_t>{1, 2, 3}));
  EXPECT_TRUE(first.recycled.empty());
  EXPECT_EQ(table.room(Eviction::unused), 0u);
  for (const std::uint32_t slot : first.slots) table.put(slot, 10 * static_cast<int>(slot));
  table.usage().touch(2, 7);
  table.order_by_use(7, 7);
  EXPECT_EQ(table.room(Eviction::unused), 2u);
  EXPECT_EQ(table.room(Eviction::any), 3u);
  const TakenSlots taken = table.take(1, Eviction::unused);
  EXPECT_EQ(taken.slots, (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(taken.recycled, (std::vector<std::uint32_t>{1}));
  EXPECT_FALSE(table.contains(10));
  EXPECT_EQ(table.find(20), 2u);
  EXPECT_FALSE(table.occupied(1));
}

/// Against a list in order of use and a map, under random operations.
TEST(SlotTable, agrees_with_a_list_and_a_map) {
  constexpr std::uint32_t kSlots = 61;
  std::mt19937 generator(5);
  const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
  SlotTable<std::uint32_t> table(exec::Device::cpu(), kSlots);
  std::vector<std::uint32_t> order(kSlots);
  for (std::uint32_t i = 0; i < kSlots; ++i) order[i] = i;
  std::map<std::uint32_t, std::uint32_t> name_in;
  std::uint32_t next_name = 0;
  std::vector<std::uint32_t> withheld;
  for (std::uint32_t pass = 1; pass < 400; ++pass) {
    std::vector<bool> used(kSlots);
    for (std::uint32_t i = random() % kSlots; i > 0; --i) {
      const auto slot = random() % kSlots;
      used[slot] = true;
      table.usage().touch(slot, pass);
    }
    table.order_by_use(pass, pass);
    const auto middle =
        std::stable_partition(order.begin(), order.end(), [&](auto slot) { return !used[slot]; });
    auto unused = static_cast<std::uint32_t>(middle - order.begin());
    ASSERT_EQ(table.room(Eviction::unused), unused);
    if (random() % 8 == 0) {
      const auto back = random() % (static_cast<std::uint32_t>(withheld.size()) + 1);
      table.restore(back);
      for (std::uint32_t i = 0; i < back; ++i) {
        order.insert(order.begin() + i, withheld.back());
        withheld.pop_back();
      }
      unused += back;
    }
    if (random() % 8 == 0) {
      const auto gone = random() % (static_cast<std::uint32_t>(order.size()) / 2 + 1);
      const TakenSlots taken = table.withhold(gone);
      ASSERT_EQ(taken.slots, std::vector<std::uint32_t>(order.begin(), order.begin() + gone));
      for (const std::uint32_t slot : taken.slots) name_in.erase(slot);
      order.erase(order.begin(), order.begin() + gone);
      withheld.insert(withheld.end(), taken.slots.rbegin(), taken.slots.rend());
      unused -= std::min(unused, gone);
    }
    ASSERT_EQ(table.withheld(), withheld.size());
    const auto givable = static_cast<std::uint32_t>(order.size());
    const Eviction eviction = random() % 2 == 0 ? Eviction::unused : Eviction::any;
    const std::size_t wanted = random() % kSlots;
    const TakenSlots taken = table.take(wanted, eviction);
    const std::size_t count = std::min<std::size_t>(wanted, eviction == Eviction::any ? givable : unused);
    ASSERT_EQ(taken.slots,
              std::vector<std::uint32_t>(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count)));
    std::vector<std::uint32_t> recycled;
    for (const std::uint32_t slot : taken.slots) {
      if (name_in.erase(slot) > 0) recycled.push_back(slot);
    }
    ASSERT_EQ(taken.recycled, recycled);
    std::rotate(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end());
    for (const std::uint32_t slot : taken.slots) {
      if (random() % 4 == 0) continue;
      name_in[slot] = next_name;
      table.put(slot, next_name++);
    }
    table.check_invariants();
    ASSERT_EQ(table.size(), name_in.size());
    for (const auto& [slot, name] : name_in) ASSERT_EQ(table.find(name), slot);
  }
}

}  // namespace
}  // namespace gvx::cache
