// Production with threads, clients that change their minds, and producers that are slow, fail, drop and
// complete out of order; a model says what may be delivered.

#include <map>
#include <random>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "gvx/produce/production_test_support.h"

namespace gvx::produce {
namespace {

/// Answers a remote producer's requests from a thread of its own: out of order, some late, some dropped.
class Answering {
 public:
  explicit Answering(const RemoteProducer& remote) : remote_(remote), thread_([this] { run(); }) {}
  Answering(const Answering&) = delete;
  Answering& operator=(const Answering&) = delete;
  ~Answering() {
    stopping_ = true;
    thread_.join();
  }

  std::atomic<int> dropped{0};

 private:
  void run() {
    std::mt19937 random(3);
    std::vector<RemoteProducer::Request> open;
    while (!stopping_) {
      for (auto& request : remote_.take(0)) open.push_back(std::move(request));
      if (open.empty()) std::this_thread::yield();
      std::shuffle(open.begin(), open.end(), random);
      for (std::size_t answers = open.empty() ? 0 : random() % open.size() + 1; answers > 0; --answers) {
        answer(open.back());
        open.pop_back();
      }
    }
  }
  void answer(const RemoteProducer::Request& request) {
    if (request.sink->cancelled(request.element)) {
      request.sink->drop(request.element);
      ++dropped;
    } else {
      request.answer();
    }
  }

  const RemoteProducer& remote_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

/// Takes its time with some bricks; every seventh fails or throws. Counts how often each was begun.
class SlowProducer final : public SmallProducer {
 public:
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    if (key.x % 5 == 0) std::this_thread::sleep_for(std::chrono::microseconds(50));
    {
      const std::lock_guard lock(mutex_);
      ++begun_[key.x];
    }
    NodeKey with_fate = key;
    if (key.x % 7 == 0) with_fate.y = key.x % 2 == 0 ? 98 : 99;
    return SmallProducer::produce(with_fate, voxels);
  }
  std::map<std::uint64_t, int> begun() const {
    const std::lock_guard lock(mutex_);
    return begun_;
  }

 private:
  mutable std::mutex mutex_;
  mutable std::map<std::uint64_t, int> begun_;
};

/// What was wanted since it was last taken, and so may still come.
class Expected {
 public:
  void want(ClientId client, Tier tier, const std::vector<ElementKey>& keys) {
    auto& list = wanted_[{client.value, tier}];
    list = {keys.begin(), keys.end()};
    may_come_.insert(keys.begin(), keys.end());
  }
  void leave(ClientId client) {
    wanted_.erase({client.value, Tier::visible});
    wanted_.erase({client.value, Tier::ahead});
  }
  void take(const FinishedElement& finished) {
    EXPECT_EQ(may_come_.erase(finished.key), 1u) << "nobody wanted it, or it came twice";
    for (auto& [who, keys] : wanted_) keys.erase(finished.key);
    const bool fails = finished.key.tree.value == 0 && finished.key.node.x % 7 == 0;
    EXPECT_EQ(finished.element.ok(), !fails);
    if (!finished.element.ok()) return;
    const auto x = static_cast<float>(finished.key.node.x);
    EXPECT_EQ(finished.element.value().found->channel[0], (ValueRange{x, x}));
  }
  bool satisfied() const {
    return std::ranges::all_of(wanted_, [](const auto& list) { return list.second.empty(); });
  }

 private:
  struct Less {
    bool operator()(const ElementKey& a, const ElementKey& b) const {
      return std::pair(a.tree.value, a.node.x) < std::pair(b.tree.value, b.node.x);
    }
  };
  using Keys = std::set<ElementKey, Less>;
  std::map<std::pair<std::uint32_t, Tier>, Keys> wanted_;
  Keys may_come_;
};

class ProductionWithClients : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(, ProductionWithClients, testing::Values(1u, 2u, 3u, 4u));

TEST_P(ProductionWithClients, delivers_what_is_wanted_exactly_once_whatever_clients_do) {
  std::mt19937 generator(GetParam());
  const auto random = [&](std::uint32_t below) { return static_cast<std::uint32_t>(generator()) % below; };
  const auto slow = std::make_shared<SlowProducer>();
  const auto remote = std::make_shared<RemoteProducer>(20, 3);
  Answering answering(*remote);
  Production production(static_cast<int>(1 + GetParam() % 3));
  const TreeId trees[] = {production.add(slow), production.add(remote)};
  Expected expected;
  std::vector<ClientId> clients;
  const auto take = [&] {
    for (const FinishedElement& finished : production.take_finished()) expected.take(finished);
  };
  for (int step = 0; step < 1500; ++step) {
    const std::uint32_t what = random(20);
    if (clients.empty() || (what == 0 && clients.size() < 6))
      clients.push_back(production.add_client(1 + random(4)));
    const std::size_t chosen = random(static_cast<std::uint32_t>(clients.size()));
    if (what == 1) {
      production.remove_client(clients[chosen]);
      expected.leave(clients[chosen]);
      clients.erase(clients.begin() + static_cast<std::ptrdiff_t>(chosen));
    } else if (what < 10) {
      const Tier tier = random(3) == 0 ? Tier::ahead : Tier::visible;
      std::vector<ElementKey> keys;
      for (std::uint32_t i = random(40); i > 0; --i) keys.push_back(brick_of(trees[random(2)], random(100)));
      expected.want(clients[chosen], tier, keys);
      production.want(clients[chosen], tier, keys);
    } else if (what < 15) {
      production.wait_until(clients[chosen], in_a_minute());
    }
    if (random(2) == 0) take();
    ASSERT_FALSE(HasFailure()) << "at step " << step;
  }
  for (const ClientId client : clients) {
    while (!production.idle(client)) {
      production.wait_until(client, in_a_minute());
      take();
    }
  }
  EXPECT_TRUE(expected.satisfied());
  EXPECT_GT(slow->begun().size(), 50u);
}

TEST(ProductionModel, clients_share_by_weight_and_one_that_wants_ten_need_not_wait) {
  const auto remote = std::make_shared<RemoteProducer>(1);
  Production production(2);
  const TreeId tree = production.add(remote);
  const ClientId gate = production.add_client(), one = production.add_client(1),
                 three = production.add_client(3);
  production.want(gate, Tier::visible, bricks_of(tree, 99, 1));
  const auto first = remote->take(1);
  production.want(one, Tier::visible, bricks_of(tree, 1000, 5000));
  production.want(three, Tier::visible, bricks_of(tree, 100000, 5000));
  first[0].answer();
  const auto begun = [&](int count) {
    std::map<std::uint64_t, int> of_client;  // by the first of its keys
    for (int i = 0; i < count; ++i) {
      const auto request = remote->take(1);
      const std::uint64_t x = request.at(0).node.x;
      ++of_client[x >= 1000000 ? 2 : x >= 100000 ? 1 : 0];
      request[0].answer();
    }
    return of_client;
  };
  auto shares = begun(400);
  EXPECT_NEAR(shares[0], 100, 2);
  EXPECT_NEAR(shares[1], 300, 2);
  production.want(production.add_client(1), Tier::visible, bricks_of(tree, 1000000, 10));
  EXPECT_EQ(begun(52)[2], 10);
}

TEST(ProductionModel, clients_of_several_threads_do_not_disturb_each_other) {
  const auto slow = std::make_shared<SlowProducer>();
  Production production(2);
  const TreeId tree = production.add(slow);
  std::atomic<int> delivered{0};
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < 3; ++t) {
    threads.emplace_back([&, t] {
      const ClientId client = production.add_client();
      for (std::uint64_t round = 0; round < 20; ++round) {
        production.want(client, Tier::visible, bricks_of(tree, t * 1000 + round * 10, 10));
        while (!production.idle(client)) {
          production.wait_until(client, in_a_minute());
          delivered += static_cast<int>(production.take_finished().size());
        }
      }
      production.remove_client(client);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(delivered, 600);
  EXPECT_TRUE(std::ranges::all_of(slow->begun(), [](const auto& begun) { return begun.second == 1; }));
}

}  // namespace
}  // namespace gvx::produce
