#include "gvx/io/external_sort.h"

#include <csignal>
#include <random>

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace gvx::io {
namespace {

struct Record {
  std::uint64_t key = 0;
  std::uint32_t other = 0;
};

struct ByKey {
  bool operator()(const Record& a, const Record& b) const { return a.key < b.key; }
};

using Sorter = ExternalSorter<Record, ByKey>;

/// What a sorter makes of records that are pushed in this order.
std::vector<std::uint64_t> sorted(const std::vector<std::uint64_t>& keys, std::uint64_t memory_bytes) {
  Sorter sorter(testing::TempDir(), memory_bytes, keys.size(), ByKey());
  for (const std::uint64_t key : keys) EXPECT_TRUE(sorter.push({key, 7}).ok());
  std::vector<std::uint64_t> out;
  const Status done = sorter.for_each([&](const Record& record) -> Status {
    EXPECT_EQ(record.other, 7u);
    out.push_back(record.key);
    return {};
  });
  EXPECT_TRUE(done.ok());
  return out;
}

TEST(ExternalSort, sorts_as_memory_would_whatever_fits) {
  std::mt19937 random(5);
  for (const std::size_t count : {0u, 1u, 2u, 3u, 100u, 50000u}) {
    std::vector<std::uint64_t> keys(count);
    for (std::uint64_t& key : keys) key = random() % 3000;
    std::vector<std::uint64_t> expected = keys;
    std::sort(expected.begin(), expected.end());
    // All in memory; a few runs; as many runs as may be; runs that end just with the records.
    for (const std::size_t records : {100000u, 7000u, 64u, 25u}) {
      EXPECT_EQ(sorted(keys, records * sizeof(Record)), expected) << count << " in " << records;
    }
  }
}

TEST(ExternalSort, says_what_the_disk_says) {
  Sorter nowhere("/nowhere/at/all", 2 * sizeof(Record), 100, ByKey());
  ASSERT_TRUE(nowhere.push({1}).ok());
  const Status refused = nowhere.push({2});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("/nowhere/at/all: cannot create"), std::string::npos)
      << refused.error().message;

  // A file that may not grow is as a disk that is full.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1 << 16, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  Status status;
  Sorter full(testing::TempDir(), 1 << 12, 100000, ByKey());
  for (int i = 0; i < 100000 && status.ok(); ++i) status = full.push({1});
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("cannot write a scratch file"), std::string::npos)
      << status.error().message;
}

TEST(ScratchList, gives_back_what_was_written_in_pieces) {
  auto list = ScratchList<Record>::create(testing::TempDir()).value();
  std::uint64_t pushed = 0;
  for (const int more : {3, 0, 40000, 1}) {
    for (int i = 0; i < more; ++i, ++pushed) ASSERT_TRUE(list.push({pushed * pushed, 1}).ok());
    ASSERT_TRUE(list.flush().ok());
    ASSERT_EQ(list.size(), pushed);
    std::vector<Record> last(std::min<std::size_t>(pushed, 5));
    ASSERT_TRUE(list.read(pushed - last.size(), last).ok());
    for (std::size_t i = 0; i < last.size(); ++i) {
      const std::uint64_t n = pushed - last.size() + i;
      EXPECT_EQ(last[i].key, n * n);
    }
  }
  ScratchReader<Record> reader(list, 10, 20000, 999);
  for (std::uint64_t n = 10; n < 20010; ++n) ASSERT_EQ(reader.next().value()->key, n * n);
  EXPECT_EQ(reader.next().value(), nullptr);
}

}  // namespace
}  // namespace gvx::io
