#include "gvx/cache/request_marks.h"

#include <gtest/gtest.h>

namespace gvx::cache {
namespace {

TEST(RequestMarks, collects_each_marked_node_once_and_forgets) {
  RequestMarks marks(exec::Device::cpu(), 100);
  marks.view().request(NodeIndex(70), kNeedsBrick, 0.5f);
  marks.view().request(NodeIndex(3), kNeedsChildren, 1.0f);
  marks.view().request(NodeIndex(70), kNeedsBrick, 0.25f);
  const auto requests = marks.collect();
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].node, NodeIndex(3));
  EXPECT_EQ(requests[0].kinds, kNeedsChildren);
  EXPECT_EQ(requests[1].node, NodeIndex(70));
  EXPECT_GT(requests[0].priority, requests[1].priority);
  EXPECT_TRUE(marks.collect().empty());
}

TEST(RequestMarks, keeps_a_request_of_no_gain) {
  RequestMarks marks(exec::Device::cpu(), 4);
  marks.view().request(NodeIndex(0), kNeedsBrick, 0.0f);
  EXPECT_EQ(marks.collect().size(), 1u);
}

}  // namespace
}  // namespace gvx::cache
