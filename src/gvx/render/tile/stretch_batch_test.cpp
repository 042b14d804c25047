#include "gvx/render/tile/stretch_batch.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace gvx::render {
namespace {

TEST(StretchBatch, puts_all_rows_in_order_of_their_lengths) {
  const auto batch = std::make_unique<StretchBatch>();
  std::mt19937 random(1);
  for (const std::uint32_t count : {0u, 1u, 2u, 3u, 64u, 1001u, StretchBatch::kMost}) {
    for (const unsigned longest : {1u, 28u, 255u}) {
      batch->count = count;
      std::generate_n(batch->length, count,
                      [&] { return static_cast<std::uint8_t>(random() % longest + 1); });
      batch->put_in_order();
      const std::vector<std::int32_t> order(batch->order, batch->order + count);
      EXPECT_TRUE(
          std::is_sorted(order.begin(), order.end(),
                         [&](std::int32_t a, std::int32_t b) { return batch->length[a] < batch->length[b]; }))
          << count << " rows of up to " << longest;
      std::vector<std::int32_t> rows(count), found = order;
      std::iota(rows.begin(), rows.end(), 0);
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, rows) << count << " rows of up to " << longest;
    }
  }
}

}  // namespace
}  // namespace gvx::render
