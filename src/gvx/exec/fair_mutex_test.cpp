#include "gvx/exec/fair_mutex.h"

#include <atomic>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace gvx::exec {
namespace {

TEST(FairMutex, one_has_it_at_a_time) {
  FairMutex mutex;
  constexpr int kThreads = 4, kTurns = 300;
  int inside = 0;  // guarded by the mutex
  std::vector<int> turns(kThreads);
  std::atomic<int> started{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      ++started;
      while (started < kThreads) std::this_thread::yield();
      for (int i = 0; i < kTurns; ++i) {
        const FairMutex::Turn turn = mutex.take();
        EXPECT_EQ(++inside, 1);
        ++turns[static_cast<std::size_t>(t)];
        --inside;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const int count : turns) EXPECT_EQ(count, kTurns);
}

TEST(FairMutex, is_given_in_the_order_of_coming) {
  FairMutex mutex;
  FairMutex::Turn first = mutex.take();
  EXPECT_FALSE(mutex.contended());
  std::vector<int> order;  // guarded by the mutex
  std::vector<std::thread> threads;
  for (int t = 0; t < 3; ++t) {
    threads.emplace_back([&, t] {
      const FairMutex::Turn turn = mutex.take();
      order.push_back(t);
    });
    // Each is in the queue before the next one starts.
    while (mutex.waiting() < static_cast<std::size_t>(t) + 1) std::this_thread::yield();
  }
  EXPECT_TRUE(mutex.contended());
  first.end();
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2}));
}

}  // namespace
}  // namespace gvx::exec
