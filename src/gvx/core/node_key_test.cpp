#include "gvx/core/node_key.h"

#include <unordered_set>

#include <gtest/gtest.h>

namespace gvx {
namespace {

TEST(NodeKey, parent_undoes_child) {
  for (const int n : {2, 3}) {
    const NodeKey key{7, 5, 90, 31};
    for (int i = 0; i < n * n * n; ++i) EXPECT_EQ(parent(child(key, n, i), n), key);
  }
}

TEST(NodeKey, children_are_distinct_and_x_is_fastest) {
  EXPECT_EQ(child(NodeKey{}, 3, 1), (NodeKey{1, 1, 0, 0}));
  EXPECT_EQ(child(NodeKey{}, 3, 3), (NodeKey{1, 0, 1, 0}));
  EXPECT_EQ(child(NodeKey{}, 3, 26), (NodeKey{1, 2, 2, 2}));
  std::unordered_set<NodeKey, NodeKeyHash> seen;
  for (int i = 0; i < 27; ++i) seen.insert(child(NodeKey{3, 1, 2, 3}, 3, i));
  EXPECT_EQ(seen.size(), 27u);
}

}  // namespace
}  // namespace gvx
