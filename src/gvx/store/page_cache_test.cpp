#include "gvx/store/page_cache.h"

#include <atomic>
#include <thread>

#include <gtest/gtest.h>

namespace gvx::store {
namespace {

PageKey key_of(std::uint64_t offset) {
  PageKey key;
  key.ref.offset = offset;
  return key;
}

Page page_of(std::size_t bytes) {
  return std::make_shared<const std::vector<std::byte>>(bytes);
}

/// A page of 2000 bytes; counts those that were not in the cache.
Result<Page> get_page(PageCache& cache, std::uint64_t offset, int& loads) {
  return cache.get(key_of(offset), [&]() -> Result<Page> {
    ++loads;
    return page_of(2000);
  });
}

TEST(PageCache, keeps_what_was_asked_for_last_within_its_bound) {
  PageCache cache(10'000);
  int loads = 0;
  const auto get = [&](std::uint64_t offset) { return get_page(cache, offset, loads); };
  for (std::uint64_t i = 0; i < 100; ++i) {
    ASSERT_TRUE(get(i).ok());
    ASSERT_TRUE(get(0).ok());  // in use all the time
    ASSERT_LE(cache.bytes(), 10'000u);
  }
  EXPECT_EQ(loads, 100);
  EXPECT_GT(cache.bytes(), 7'000u);
  ASSERT_TRUE(get(99).ok());
  EXPECT_EQ(loads, 100);
  ASSERT_TRUE(get(50).ok());
  EXPECT_EQ(loads, 101);
}

TEST(PageCache, drops_the_oldest_where_the_bound_becomes_smaller) {
  PageCache cache(10'000);
  int loads = 0;
  const auto get = [&](std::uint64_t offset) { return get_page(cache, offset, loads); };
  for (std::uint64_t i = 0; i < 4; ++i) ASSERT_TRUE(get(i).ok());
  cache.set_bound(5'000);
  EXPECT_LE(cache.bytes(), 5'000u);
  ASSERT_TRUE(get(3).ok());
  EXPECT_EQ(loads, 4);
  cache.set_bound(0);
  EXPECT_EQ(cache.bytes(), 0u);
  ASSERT_TRUE(get(3).ok());
  EXPECT_EQ(loads, 5) << "what cannot be kept is read each time";
}

TEST(PageCache, one_of_many_threads_loads) {
  PageCache cache(1 << 20);
  std::atomic<int> loads{0}, right{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (std::uint64_t i = 0; i < 200; ++i) {
        const auto page = cache.get(key_of(i), [&]() -> Result<Page> {
          ++loads;
          std::this_thread::yield();
          return page_of(static_cast<std::size_t>(i) + 1);
        });
        if (page.value()->size() == i + 1) ++right;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(loads, 200);
  EXPECT_EQ(right, 8 * 200);
}

TEST(PageCache, many_threads_in_a_cache_that_is_too_small_get_the_right_pages) {
  PageCache cache(3000);
  std::atomic<int> right{0};
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (std::uint64_t i = 0; i < 2000; ++i) {
        const std::uint64_t wanted = i * (t + 1) % 17;
        const auto page = cache.get(key_of(wanted), [&]() -> Result<Page> {
          return page_of(static_cast<std::size_t>(wanted) * 10 + 500);
        });
        if (page.value()->size() == wanted * 10 + 500) ++right;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(right, 4 * 2000);
  EXPECT_LE(cache.bytes(), 3000u);
}

TEST(PageCache, what_failed_is_tried_again) {
  PageCache cache(1 << 20);
  const auto failed = cache.get(key_of(1), []() -> Result<Page> { return Error{"no"}; });
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "no");
  EXPECT_TRUE(cache.get(key_of(1), [] { return Result<Page>(page_of(5)); }).ok());
}

TEST(PageCache, pages_of_one_place_that_are_read_in_two_ways_are_two) {
  PageCache cache(1 << 20);
  PageKey records = key_of(1), references = key_of(1);
  records.of_records = true;
  EXPECT_EQ(cache.get(records, [] { return Result<Page>(page_of(5)); }).value()->size(), 5u);
  EXPECT_EQ(cache.get(references, [] { return Result<Page>(page_of(6)); }).value()->size(), 6u);
}

}  // namespace
}  // namespace gvx::store
