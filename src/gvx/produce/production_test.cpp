#include "gvx/produce/production.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "gvx/produce/production_test_support.h"

namespace gvx::produce {
namespace {

std::string message_of(const FinishedElement& finished) {
  return finished.element.ok() ? "" : finished.element.error().message;
}

/// One client of one tree.
template <typename P>
struct Setting {
  std::shared_ptr<P> producer;
  Production production;
  TreeId tree = production.add(producer);
  ClientId client = production.add_client();

  template <typename... Arguments>
  explicit Setting(int threads, Arguments... arguments)
      : producer(std::make_shared<P>(arguments...)), production(threads) {}
  void want(std::vector<ElementKey> keys, Tier tier = Tier::visible) { production.want(client, tier, keys); }
};

TEST(Production, makes_what_two_clients_want_once) {
  Setting<SmallProducer> s(3);
  const ClientId other = s.production.add_client();
  std::vector<ElementKey> keys = bricks_of(s.tree, 0, 200);
  keys.push_back({s.tree, {3, 4, 5, 6}, ElementKind::children});
  keys.push_back(keys[0]);
  s.want(keys);
  s.production.want(other, Tier::ahead, keys);
  const std::vector<FinishedElement> all = finish(s.production, s.client);
  EXPECT_TRUE(s.production.idle(other));
  ASSERT_EQ(all.size(), 201u);
  EXPECT_EQ(s.producer->made, 200);
  for (const FinishedElement& one : all) {
    ASSERT_TRUE(one.element.ok());
    const Element& element = one.element.value();
    if (one.key.kind == ElementKind::children) {
      EXPECT_EQ(element.child_keys[7], (NodeKey{4, 9, 11, 13}));
      EXPECT_EQ(element.children[1].ranges.channel[0], (ValueRange{0, 9}));
    } else {
      const auto x = static_cast<float>(one.key.node.x);
      EXPECT_EQ(element.found->channel[0], (ValueRange{x, x}));
      EXPECT_FALSE(element.constant) << "an interior brick of one value is no constant";
    }
  }
}

TEST(Production, a_finest_brick_of_one_value_is_a_constant) {
  Setting<SmallProducer> s(1);
  s.want({{s.tree, {20, 7, 0, 0}, ElementKind::brick}});
  const auto made = finish(s.production, s.client);
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made[0].element.value().constant->channel[0], (ValueRange{7, 7}));
}

TEST(Production, errors_and_exceptions_are_those_of_their_elements) {
  Setting<SmallProducer> s(2);
  s.want({brick_of(s.tree, 1, 98), brick_of(s.tree, 2, 99), brick_of(s.tree, 3)});
  const auto made = finish(s.production, s.client);
  ASSERT_EQ(made.size(), 3u);
  for (const FinishedElement& one : made) {
    const std::string expected[] = {"a producer failed: a bad day", "no such brick", ""};
    EXPECT_EQ(message_of(one), expected[one.key.node.x - 1]);
  }
}

TEST(Production, fifty_requests_are_under_way_on_two_threads) {
  Setting<RemoteProducer> s(2, 50);
  s.want(bricks_of(s.tree, 0, 60));
  auto requests = s.producer->take(50);
  ASSERT_EQ(requests.size(), 50u);
  EXPECT_TRUE(s.production.take_finished().empty());
  std::thread remote([&] {
    std::reverse(requests.begin(), requests.end());
    for (const auto& request : requests) request.answer();
    for (const auto& request : s.producer->take(10)) request.answer();
  });
  const auto made = finish(s.production, s.client);
  remote.join();
  EXPECT_EQ(made.size(), 60u);
  EXPECT_TRUE(std::all_of(made.begin(), made.end(), [](const auto& one) { return one.element.ok(); }));
}

TEST(Production, no_more_batches_are_under_way_than_a_producer_likes) {
  Setting<RemoteProducer> s(4, 3, 5);
  s.want(bricks_of(s.tree, 0, 100));
  std::size_t answered = 0;
  while (answered < 100) {
    const auto requests = s.producer->take(1);
    EXPECT_LE(requests.size(), 15u);
    for (const auto& request : requests) request.answer();
    answered += requests.size();
  }
  EXPECT_EQ(finish(s.production, s.client).size(), 100u);
}

TEST(Production, what_is_ahead_is_begun_when_nothing_visible_waits) {
  Setting<RemoteProducer> s(1, 1);
  const ClientId other = s.production.add_client();
  s.want({brick_of(s.tree, 0)});
  const auto first = s.producer->take(1);
  s.want(bricks_of(s.tree, 10, 3), Tier::ahead);
  s.production.want(other, Tier::visible, bricks_of(s.tree, 20, 3));
  first[0].answer();
  std::vector<std::uint64_t> order;
  for (int i = 0; i < 6; ++i) {
    const auto request = s.producer->take(1);
    order.push_back(request[0].node.x);
    request[0].answer();
  }
  EXPECT_EQ(order, (std::vector<std::uint64_t>{20, 21, 22, 10, 11, 12}));
}

TEST(Production, what_nobody_wants_any_more_is_not_begun) {
  Setting<RemoteProducer> s(1, 1);
  s.want(bricks_of(s.tree, 0, 100));
  const auto begun = s.producer->take(1);
  EXPECT_FALSE(begun[0].sink->cancelled(0));
  s.want({});
  EXPECT_TRUE(s.production.idle(s.client));
  EXPECT_TRUE(begun[0].sink->cancelled(0));
  begun[0].answer();
  // What was under way is finished all the same.
  EXPECT_EQ(s.production.take_finished().size(), 1u);
  s.production.wait_until(in_a_minute());
  EXPECT_EQ(s.producer->waiting(), 0u);
}

TEST(Production, what_is_dropped_is_no_error_and_is_begun_again_if_it_is_wanted_again) {
  Setting<RemoteProducer> s(1, 2);
  s.want({brick_of(s.tree, 1)});
  const auto first = s.producer->take(1);
  s.want({});
  ASSERT_TRUE(first[0].sink->cancelled(0));
  s.want({brick_of(s.tree, 1)});
  first[0].sink->drop(0);
  const auto again = s.producer->take(1);
  EXPECT_EQ(again[0].node, first[0].node);
  s.want({});
  ASSERT_TRUE(again[0].sink->cancelled(0));
  again[0].sink->drop(0);
  s.production.wait_until(in_a_minute());
  EXPECT_TRUE(s.production.take_finished().empty());
}

TEST(Production, dropping_what_is_wanted_is_an_error) {
  Setting<RemoteProducer> s(1, 1);
  s.want({brick_of(s.tree, 1, 2)});
  s.producer->take(1)[0].sink->drop(0);
  const auto made = finish(s.production, s.client);
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(message_of(made[0]),
            "the brick of node (1, 2, 0) of level 10: its producer dropped it although it is wanted");
}

TEST(Production, what_a_producer_never_hands_over_is_an_error) {
  Setting<RemoteProducer> s(1, 1, 2);
  s.want({{s.tree, {1, 1, 0, 0}, ElementKind::children}});
  s.producer->take(1).clear();
  const auto made = finish(s.production, s.client);
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(message_of(made[0]),
            "the children of node (1, 0, 0) of level 1: its producer never handed it over");
}

TEST(Production, what_a_producer_hands_over_twice_is_an_error) {
  Setting<RemoteProducer> s(1, 1);
  s.want({brick_of(s.tree, 1)});
  const auto request = s.producer->take(1);
  request[0].answer();
  request[0].answer();
  auto made = finish(s.production, s.client);
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(message_of(made[0]),
            "the brick of node (1, 0, 0) of level 10: its producer handed it over twice");
  // Once the first was taken, the second is told alone.
  request[0].answer();
  made = s.production.take_finished();
  ASSERT_EQ(made.size(), 1u);
  EXPECT_FALSE(made[0].element.ok());
}

TEST(Production, a_brick_of_another_size_is_an_error) {
  Setting<RemoteProducer> s(1, 1);
  s.want({brick_of(s.tree, 1)});
  s.producer->take(1)[0].sink->complete(0, Element{});
  const auto made = finish(s.production, s.client);
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(message_of(made[0]), "the brick of node (1, 0, 0) of level 10: expected " +
                                     std::to_string(s.producer->description().brick_bytes()) +
                                     " bytes, its producer made 0");
}

TEST(Production, what_was_taken_is_made_again_when_it_is_wanted_again) {
  Setting<SmallProducer> s(1);
  for (int i = 1; i <= 3; ++i) {
    s.want({brick_of(s.tree, 5)});
    EXPECT_EQ(finish(s.production, s.client).size(), 1u);
    EXPECT_EQ(s.producer->made, i);
  }
}

TEST(Production, what_is_finished_and_not_taken_is_not_made_again) {
  Setting<SmallProducer> s(1);
  for (int i = 0; i < 3; ++i) {
    s.want({brick_of(s.tree, 5)});
    s.production.wait_until(in_a_minute());
    EXPECT_FALSE(s.production.idle(s.client));
  }
  EXPECT_EQ(s.production.take_finished().size(), 1u);
  EXPECT_EQ(s.producer->made, 1);
  EXPECT_TRUE(s.production.idle(s.client));
}

TEST(Production, waits_no_longer_than_told) {
  Setting<RemoteProducer> s(1, 1);
  s.want({brick_of(s.tree, 1)});
  const auto held = s.producer->take(1);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::milliseconds(5);
  s.production.wait_until(s.client, deadline);
  EXPECT_GE(std::chrono::steady_clock::now(), deadline);
  EXPECT_TRUE(s.production.take_finished().empty());
}

TEST(Production, a_client_waits_for_its_own_elements_only) {
  Setting<RemoteProducer> s(1, 8);
  const ClientId other = s.production.add_client();
  s.production.want(other, Tier::visible, bricks_of(s.tree, 0, 1));
  const auto held = s.producer->take(1);
  const auto before = std::chrono::steady_clock::now();
  s.production.wait_until(s.client, in_a_minute());
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(30));
  EXPECT_FALSE(s.production.idle(other));
  s.production.remove_client(other);
  EXPECT_TRUE(s.production.idle(other));
}

TEST(Production, nothing_comes_of_a_tree_that_was_removed) {
  Setting<RemoteProducer> s(2, 2);
  s.want(bricks_of(s.tree, 0, 10));
  const auto requests = s.producer->take(2);
  requests[0].answer();
  s.production.remove(s.tree);
  EXPECT_TRUE(s.production.idle(s.client));
  EXPECT_TRUE(requests[1].sink->cancelled(0));
  requests[1].answer();
  s.want(bricks_of(s.tree, 0, 10));
  EXPECT_TRUE(s.production.idle(s.client));
  EXPECT_TRUE(s.production.take_finished().empty());
  // The thread that started the last batch may hold it for a moment.
  while (s.producer.use_count() > 1) std::this_thread::yield();
}

TEST(Production, stops_with_work_left_and_outlived_by_requests) {
  std::vector<RemoteProducer::Request> requests;
  {
    Setting<RemoteProducer> s(2, 4);
    s.want(bricks_of(s.tree, 0, 10000));
    requests = s.producer->take(4);
  }
  EXPECT_TRUE(requests[0].sink->cancelled(0));
  for (const auto& request : requests) request.answer();
}

TEST(Production, counts_the_time_of_starting) {
  Setting<SmallProducer> s(1);
  s.want(bricks_of(s.tree, 0, 50));
  EXPECT_EQ(finish(s.production, s.client).size(), 50u);
  EXPECT_GT(s.production.making_milliseconds(), 0);
}

}  // namespace
}  // namespace gvx::produce
