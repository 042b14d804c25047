#include "gvx/mesh/mesh_proxy.h"

#include <gtest/gtest.h>

#include "gvx/mesh/mesh_test_support.h"
#include "gvx/produce/field_producer.h"

namespace gvx::mesh {
namespace {

/// Where a ball is, at 0.3 around the middle of the cube.
std::shared_ptr<const produce::Producer> ball() {
  produce::TreeDescription tree;
  tree.max_level = 4;
  return std::make_shared<produce::FieldProducer>(
      tree, [](Vec3d p) { return static_cast<float>(0.3 - length(p - Vec3d(0.5))); },
      [](const Box3d& box) {
        const double middle = 0.3 - length(0.5 * (box.minimum + box.maximum) - Vec3d(0.5));
        const double reach = 0.5 * length(box.maximum - box.minimum);
        return ValueRange{static_cast<float>(middle - reach), static_cast<float>(middle + reach)};
      });
}

bool is_outside(const ChannelRanges& ranges) {
  return ranges.channel[0].maximum < 0;
}

TEST(MeshProxy, leaves_the_way_through_the_mesh_in_the_world_of_its_tree) {
  produce::TreeDescription tree;
  tree.tree_to_world = scaling(Vec3d(10));
  const auto made = MeshProxy::create(sphere_mesh({5, 5, 5}, 2, 4), tree);
  if (!made.ok()) GTEST_SKIP() << made.error().message;
  const auto& proxy = made.value();
  EXPECT_TRUE(proxy->inside({0.5, 0.5, 0.65}));
  EXPECT_FALSE(proxy->inside({0.5, 0.5, 0.75}));
  const RayInterval through = proxy->span({{0.5, 0.5, -1}, {0, 0, 1}}, false);
  EXPECT_NEAR(through.enter, 1.3, 2e-3);
  EXPECT_NEAR(through.exit, 1.7, 2e-3);
  EXPECT_EQ(proxy->span({{0.5, 0.5, 0.5}, {0, 0, 1}}, true).enter, 0);
  EXPECT_TRUE(proxy->span({{0.5, 0.75, -1}, {0, 0, 1}}, false).empty());
}

TEST(MeshProxy, is_around_the_nodes_that_can_be_seen) {
  const auto made = MeshProxy::around_nodes(*ball(), 3, is_outside);
  if (!made.ok()) GTEST_SKIP() << made.error().message;
  EXPECT_TRUE(made.value()->inside({0.5, 0.5, 0.78}));
  EXPECT_FALSE(made.value()->inside({0.02, 0.02, 0.02}));
}

TEST(MeshProxy, trees_without_an_inverse_and_levels_without_end_are_errors) {
  produce::TreeDescription flat;
  flat.tree_to_world = scaling({1, 1, 0});
  EXPECT_FALSE(MeshProxy::create(sphere_mesh({0, 0, 0}, 1, 1), flat).ok());
  const auto mesh = MeshProxy::of_nodes(*ball(), 40, is_outside);
  ASSERT_FALSE(mesh.ok());
  EXPECT_NE(mesh.error().message.find("coarser"), std::string::npos);
}

}  // namespace
}  // namespace gvx::mesh
