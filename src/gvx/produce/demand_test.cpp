#include "gvx/produce/demand.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace gvx::produce {
namespace {

constexpr TreeId kTree(0);

ElementKey key_of(std::uint64_t x, ElementKind kind = ElementKind::brick, TreeId tree = kTree) {
  return {tree, {30, x, 0, 0}, kind};
}

std::vector<ElementKey> keys_of(std::uint64_t first, std::uint64_t count) {
  std::vector<ElementKey> keys;
  for (std::uint64_t i = 0; i < count; ++i) keys.push_back(key_of(first + i));
  return keys;
}

std::size_t one_at_a_time(TreeId, std::size_t) {
  return 1;
}

Demand demand_of_one_tree() {
  Demand demand;
  demand.add_tree(kTree);
  return demand;
}

TEST(Demand, begins_the_most_urgent_first_and_a_batch_is_of_one_tree_and_kind) {
  Demand demand = demand_of_one_tree();
  demand.add_tree(TreeId(1));
  const ClientId client = demand.add_client(1);
  const ElementKey other_tree = key_of(4, ElementKind::brick, TreeId(1));
  const ElementKey children = key_of(2, ElementKind::children);
  demand.want(client, Tier::visible, std::vector{key_of(9), children, key_of(3), other_tree, key_of(1)});
  const auto four = [](TreeId, std::size_t) { return std::size_t{4}; };
  EXPECT_EQ(demand.begin(four), (std::vector{key_of(9), key_of(3), key_of(1)}));
  EXPECT_EQ(demand.begin(four), std::vector{children});
  EXPECT_EQ(demand.begin(four), std::vector{other_tree});
  EXPECT_TRUE(demand.begin(four).empty());
  EXPECT_EQ(demand.count(Stage::under_way), 5u);
}

TEST(Demand, a_tree_without_room_does_not_hold_up_another) {
  Demand demand = demand_of_one_tree();
  demand.add_tree(TreeId(1));
  const ClientId client = demand.add_client(1);
  const ElementKey other = key_of(4, ElementKind::brick, TreeId(1));
  demand.want(client, Tier::visible, std::vector{key_of(1), other});
  demand.want(client, Tier::ahead, std::vector{key_of(4)});
  const auto full = [](TreeId tree, std::size_t) { return std::size_t{tree == kTree ? 0u : 1u}; };
  EXPECT_EQ(demand.begin(full), std::vector{other});
  // Nor does what is ahead overtake the visible element that still waits.
  EXPECT_TRUE(demand.begin(full).empty());
}

/// Of so many elements that are begun, how many are each client's; their keys tell.
std::map<std::uint64_t, int> shares(Demand& demand, int elements) {
  std::map<std::uint64_t, int> begun;
  for (int i = 0; i < elements; ++i) ++begun[demand.begin(one_at_a_time).at(0).node.x / 1000000];
  return begun;
}

TEST(Demand, clients_share_by_weight) {
  Demand demand = demand_of_one_tree();
  const ClientId one = demand.add_client(1), three = demand.add_client(3), half = demand.add_client(0.5);
  demand.want(one, Tier::visible, keys_of(0, 1000));
  demand.want(three, Tier::visible, keys_of(1000000, 1000));
  demand.want(half, Tier::visible, keys_of(2000000, 1000));
  auto begun = shares(demand, 900);
  EXPECT_NEAR(begun[0], 200, 2);
  EXPECT_NEAR(begun[1], 600, 2);
  EXPECT_NEAR(begun[2], 100, 2);
}

TEST(Demand, one_that_wants_ten_is_not_kept_waiting_by_one_that_wants_very_many) {
  Demand demand = demand_of_one_tree();
  const ClientId many = demand.add_client(1);
  demand.want(many, Tier::visible, keys_of(0, 100000));
  shares(demand, 5000);
  const ClientId few = demand.add_client(1);
  demand.want(few, Tier::visible, keys_of(1000000, 10));
  EXPECT_EQ(shares(demand, 21)[1], 10);
}

TEST(Demand, who_wanted_nothing_has_saved_no_turns) {
  Demand demand = demand_of_one_tree();
  const ClientId busy = demand.add_client(1), rested = demand.add_client(1);
  demand.want(busy, Tier::visible, keys_of(0, 10000));
  shares(demand, 5000);
  demand.want(rested, Tier::visible, keys_of(1000000, 10000));
  auto begun = shares(demand, 100);
  EXPECT_NEAR(begun[0], 50, 1);
  EXPECT_NEAR(begun[1], 50, 1);
}

TEST(Demand, wanting_again_gains_no_turns) {
  Demand demand = demand_of_one_tree();
  const ClientId steady = demand.add_client(1), restless = demand.add_client(1);
  demand.want(steady, Tier::visible, keys_of(0, 10000));
  int begun_for_restless = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    demand.want(restless, Tier::visible, keys_of(1000000 + i, 100));
    begun_for_restless += shares(demand, 1)[1];
  }
  EXPECT_NEAR(begun_for_restless, 100, 1);
}

TEST(Demand, an_element_is_of_the_tier_in_which_it_is_wanted_most) {
  Demand demand = demand_of_one_tree();
  const ClientId a = demand.add_client(1), b = demand.add_client(1);
  demand.want(a, Tier::ahead, keys_of(0, 3));
  demand.want(b, Tier::visible, std::vector{key_of(2)});
  EXPECT_EQ(demand.begin(one_at_a_time), std::vector{key_of(2)});
  EXPECT_EQ(demand.begin(one_at_a_time), std::vector{key_of(0)});
  demand.remove_client(a);
  EXPECT_EQ(demand.count(Stage::waiting), 0u);
  EXPECT_TRUE(demand.begin(one_at_a_time).empty());
}

/// Says of random sequences what may be begun and what is left to do.
class Model {
 public:
  void want(std::uint32_t client, Tier tier, const std::vector<ElementKey>& keys) {
    auto& wishes = wishes_[{client, tier}];
    wishes.clear();
    for (const ElementKey& key : keys) wishes.insert(key.node.x);
  }
  void leave(std::uint32_t client) {
    wishes_.erase({client, Tier::visible});
    wishes_.erase({client, Tier::ahead});
  }
  void begin(const std::vector<ElementKey>& batch) {
    const bool visible = waits_in(Tier::visible);
    for (const ElementKey& key : batch) {
      EXPECT_TRUE(wanted_in(visible ? Tier::visible : Tier::ahead, key.node.x));
      EXPECT_TRUE(begun_.insert(key.node.x).second) << "begun twice";
    }
  }
  void give_up(const ElementKey& key) { begun_.erase(key.node.x); }
  void take(const ElementKey& key) {
    begun_.erase(key.node.x);
    for (auto& [who, wishes] : wishes_) wishes.erase(key.node.x);
  }
  bool wanted(std::uint64_t x) const { return wanted_in(Tier::visible, x) || wanted_in(Tier::ahead, x); }
  /// Does an element wait?
  bool waits_in(Tier tier) const {
    return std::ranges::any_of(wishes_, [&](const auto& line) {
      return line.first.second == tier &&
             std::ranges::any_of(line.second, [&](std::uint64_t x) { return !begun_.contains(x); });
    });
  }
  std::size_t left(std::uint32_t client) const {
    std::size_t left = 0;
    for (const auto& [who, wishes] : wishes_) left += who.first == client ? wishes.size() : 0;
    return left;
  }

 private:
  bool wanted_in(Tier tier, std::uint64_t x) const {
    return std::ranges::any_of(
        wishes_, [&](const auto& line) { return line.first.second == tier && line.second.contains(x); });
  }
  std::map<std::pair<std::uint32_t, Tier>, std::set<std::uint64_t>> wishes_;
  std::set<std::uint64_t> begun_;  // under way or finished
};

TEST(Demand, does_as_a_model_says_whatever_clients_do) {
  std::mt19937 generator(7);
  const auto random = [&](std::size_t below) { return static_cast<std::size_t>(generator()) % below; };
  Demand demand = demand_of_one_tree();
  Model model;
  std::vector<ClientId> clients;
  std::vector<ElementKey> under_way, finished;
  const auto pick = [&](std::vector<ElementKey>& from) {
    std::swap(from[random(from.size())], from.back());
    const ElementKey key = from.back();
    from.pop_back();
    return key;
  };
  std::size_t begun = 0;
  for (int step = 0; step < 20000; ++step) {
    const std::size_t what = random(10);
    if (what == 0 && clients.size() < 5) clients.push_back(demand.add_client(1.0 + double(random(4))));
    if (what == 1 && !clients.empty() && random(20) == 0) {
      std::swap(clients[random(clients.size())], clients.back());
      demand.remove_client(clients.back());
      model.leave(clients.back().value);
      clients.pop_back();
    }
    if (what == 2 && !clients.empty()) {
      const ClientId client = clients[random(clients.size())];
      const Tier tier = random(2) == 0 ? Tier::visible : Tier::ahead;
      std::vector<ElementKey> keys;
      for (std::size_t i = random(30); i > 0; --i) keys.push_back(key_of(random(60)));
      demand.want(client, tier, keys);
      model.want(client.value, tier, keys);
    }
    if (what >= 3 && what <= 6) {
      const std::vector<ElementKey> batch =
          demand.begin([&](TreeId, std::size_t waiting) { return std::min<std::size_t>(waiting, 3); });
      EXPECT_EQ(batch.empty(), !model.waits_in(Tier::visible) && !model.waits_in(Tier::ahead));
      model.begin(batch);
      under_way.insert(under_way.end(), batch.begin(), batch.end());
      begun += batch.size();
    }
    if (what == 7 && !under_way.empty()) {
      const ElementKey key = pick(under_way);
      demand.give_up(key);
      model.give_up(key);
    }
    if (what == 8 && !under_way.empty()) {
      finished.push_back(pick(under_way));
      demand.finish(finished.back());
    }
    if (what == 9 && !finished.empty()) {
      const ElementKey key = pick(finished);
      demand.take(key);
      model.take(key);
    }
    for (const ClientId client : clients) {
      EXPECT_EQ(demand.count(client, Stage::waiting) + demand.count(client, Stage::under_way) +
                    demand.count(client, Stage::finished),
                model.left(client.value));
    }
    for (std::uint64_t x = 0; x < 60; ++x) EXPECT_EQ(demand.wanted(key_of(x)), model.wanted(x));
    ASSERT_FALSE(HasFailure()) << "at step " << step;
  }
  EXPECT_GT(begun, 2000u);
}

}  // namespace
}  // namespace gvx::produce
