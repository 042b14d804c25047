#include "gvx/render/frame.h"

#include <gtest/gtest.h>

namespace gvx::render {
namespace {

View simple_view() {
  View view;
  view.camera = {{0.5, 0.5, -3}, {0.5, 0.5, 0.5}, {0, 1, 0}, 30, 0};
  view.functions = {{{{0, {1, 1, 1}}}, {{0, 0}, {1, 1}}, 0, {}}};
  view.width = view.height = 100;
  return view;
}

TEST(Frame, level_follows_the_cone) {
  const TreePlacement tree{2, 16, 5, {}, {}, {{0, 0, 0}, {1, 1, 1}}, 1, 0, {}};
  const Frame frame = Frame::make(exec::Device::cpu(), simple_view(), tree).value();
  const FrameView v = frame.view();
  const double finest_voxel = 1.0 / (16 * 32);
  EXPECT_EQ(v.zone_at(0, 0).level, 5);
  for (int level = 0; level < 5; ++level) {
    // Level l serves from where two of its voxels are as wide as the pixel.
    const double t = 2 * finest_voxel * static_cast<double>(1 << (5 - level)) / v.camera.pixel;
    EXPECT_EQ(v.zone_at(t * 1.0001, 0).level, level);
    EXPECT_EQ(v.zone_at(t * 0.9999, 0).level, level + 1);
    EXPECT_EQ(v.stride[level], 1 << (5 - level));
  }
}

TEST(Frame, without_level_of_detail_all_is_finest) {
  View view = simple_view();
  view.level_of_detail = false;
  const TreePlacement tree{3, 8, 4, {}, {}, {{0, 0, 0}, {1, 1, 1}}, 1, 0, {}};
  EXPECT_EQ(Frame::make(exec::Device::cpu(), view, tree).value().view().zone_at(1e12, 0).level, 4);
}

TEST(Frame, bad_views_are_errors) {
  const TreePlacement tree;
  const auto fails = [&](auto change) {
    View view = simple_view();
    change(view);
    return !Frame::make(exec::Device::cpu(), view, tree).ok();
  };
  EXPECT_FALSE(fails([](View&) {}));
  EXPECT_TRUE(fails([](View& v) { v.width = 0; }));
  EXPECT_TRUE(fails([](View& v) { v.height = 1u << 20; }));
  EXPECT_TRUE(fails([](View& v) { v.clip.minimum.x = 2; }));
  EXPECT_TRUE(fails([](View& v) { v.functions[0].opacities.clear(); }));
  EXPECT_TRUE(fails([](View& v) { v.camera.target = v.camera.eye; }));
  EXPECT_TRUE(fails([](View& v) { v.samples_per_voxel = 0; }));
  EXPECT_TRUE(fails([](View& v) { v.detail = 0; }));
  EXPECT_TRUE(fails([](View& v) { v.antialias = 9; }));
  EXPECT_TRUE(fails([](View& v) { v.lighting.lights = 99; }));
}

}  // namespace
}  // namespace gvx::render
