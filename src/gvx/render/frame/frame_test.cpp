#include "gvx/render/frame/frame.h"

#include <cmath>

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

tree::TreeDescription tree_of(std::uint32_t n, std::uint32_t m, std::uint32_t max_level, double scale = 1) {
  tree::TreeDescription tree;
  tree.n = n;
  tree.m = m;
  tree.max_level = max_level;
  tree.scale = scale;
  return tree;
}

TEST(Frame, level_follows_the_cone) {
  const tree::TreeDescription tree = tree_of(2, 16, 5);
  const Frame frame = Frame::make(exec::Device::cpu(), simple_view(), tree).value();
  const FrameView v = frame.view();
  const double finest_voxel = 1.0 / (16 * 32), pixel = film_of(simple_view()).value().camera.pixel;
  EXPECT_EQ(v.zone_at(0, 0).level, 5);
  for (int level = 0; level < 5; ++level) {
    // Level l serves from where two of its voxels are as wide as the pixel.
    const double t = 2 * finest_voxel * static_cast<double>(1 << (5 - level)) / pixel;
    EXPECT_EQ(v.zone_at(t * 1.0001, 0).level, level);
    EXPECT_EQ(v.zone_at(t * 0.9999, 0).level, level + 1);
    EXPECT_EQ(v.stride[level], 1 << (5 - level));
  }
}

/// Goes along a ray step by step: a zone says the same of all of its steps, is of whole steps, and ends where
/// the next one begins.
void expect_whole_steps(const FrameView& v, double enter, bool long_steps) {
  double tick = 0;
  int zones = 0;
  while (true) {
    const FrameView::Zone zone = v.zone_at(enter, tick);
    const double stride = v.stride_of(zone.level, zone.blended);
    EXPECT_EQ(stride, v.stride[long_steps && zone.blended ? zone.level - 1 : zone.level]);
    ASSERT_GT(zone.end, tick);
    ++zones;
    if (zone.end == FrameView::kNever) {
      EXPECT_EQ(zone.level, 0);
      break;
    }
    const double steps = (zone.end - tick) / stride;
    ASSERT_EQ(steps, std::floor(steps)) << "level " << zone.level << " from " << tick;
    for (const double step : {0.0, std::floor(steps / 2), steps - 1}) {
      const FrameView::Zone again = v.zone_at(enter, tick + step * stride);
      ASSERT_EQ(again.level, zone.level) << "step " << step << " of " << steps << " from " << tick;
      ASSERT_EQ(again.blended, zone.blended);
      ASSERT_EQ(again.end, zone.end);
    }
    tick = zone.end;
  }
  EXPECT_GE(zones, 3);
}

TEST(Frame, zones_are_of_whole_steps) {
  for (const std::uint32_t n : {2u, 3u}) {
    const tree::TreeDescription tree = tree_of(n, 16, 4);
    for (const double samples : {1.0, 2.0, 2.5, 3.0, 4.0}) {
      View view = simple_view();
      view.samples_per_voxel = samples;
      for (const auto classification : {scene::Classification::post, scene::Classification::preintegrated}) {
        view.classification = classification;
        const Frame frame = Frame::make(exec::Device::cpu(), view, tree).value();
        // No step may be longer than a voxel of the finer level.
        const bool long_steps =
            classification == scene::Classification::preintegrated && samples >= double(n);
        EXPECT_EQ(frame.view().blends_in_long_steps, long_steps) << n << " " << samples;
        for (const double enter : {0.0, 0.37, 2.3}) expect_whole_steps(frame.view(), enter, long_steps);
      }
    }
  }
}

TEST(Frame, without_level_of_detail_all_is_finest) {
  View view = simple_view();
  view.level_of_detail = false;
  const tree::TreeDescription tree = tree_of(3, 8, 4);
  EXPECT_EQ(Frame::make(exec::Device::cpu(), view, tree).value().view().zone_at(1e12, 0).level, 4);
}

TEST(Frame, greatest_values_from_afar_take_more_rays) {
  const tree::TreeDescription tree = tree_of(2, 16, 5);
  const auto rays = [&](double distance, auto change) {
    View view = simple_view();
    view.width = view.height = 400;
    view.mode = scene::Mode::maximum;
    view.camera.eye.z = -distance;
    change(view);
    return subrays_of(view, tree);
  };
  const auto as_it_is = [](View&) {};
  // Pixels are two voxels wide 2.9 from the eye, or times the rays along one.
  EXPECT_EQ(rays(1.5, as_it_is), 1u);
  EXPECT_EQ(rays(3, as_it_is), 4u);
  EXPECT_EQ(rays(3, [](View& v) { v.mode = scene::Mode::minimum; }), 4u);
  EXPECT_EQ(rays(3, [](View& v) { v.mode = scene::Mode::mean; }), 1u);
  EXPECT_EQ(rays(3, [](View& v) { v.mode = scene::Mode::composite; }), 1u);
  EXPECT_EQ(rays(3, [](View& v) { v.level_of_detail = false; }), 1u);
  EXPECT_EQ(rays(3, [](View& v) { v.camera.height_world = 1.5; }), 1u);
  EXPECT_EQ(rays(3, [](View& v) { v.camera.height_world = 1.7; }), 4u);
  // As many as a picture may have.
  EXPECT_EQ(rays(4, [](View& v) { v.antialias = 2; }), 1u);
  EXPECT_EQ(rays(70, [](View& v) { v.antialias = 2; }), 2u);
  EXPECT_EQ(rays(70, [](View& v) { v.antialias = 8; }), 1u);
  EXPECT_EQ(rays(70, [](View& v) { v.width = 640, v.height = 720; }), 3u);
  EXPECT_EQ(rays(70, [](View& v) { v.width = 1920, v.height = 1080; }), 2u);
  EXPECT_EQ(rays(70, [](View& v) { v.width = v.height = 4000; }), 1u);
}

TEST(Frame, a_negative_slope_turns_greatest_and_least_around) {
  const auto mode_of = [](scene::Mode mode, double scale) {
    View view = simple_view();
    view.mode = mode;
    const tree::TreeDescription tree = tree_of(2, 16, 5, scale);
    return Frame::make(exec::Device::cpu(), view, tree).value().view().visibility.mode;
  };
  EXPECT_EQ(mode_of(scene::Mode::maximum, 2), scene::Mode::maximum);
  EXPECT_EQ(mode_of(scene::Mode::maximum, -2), scene::Mode::minimum);
  EXPECT_EQ(mode_of(scene::Mode::minimum, -2), scene::Mode::maximum);
  EXPECT_EQ(mode_of(scene::Mode::mean, -2), scene::Mode::mean);
}

TEST(Frame, bad_views_are_errors) {
  const tree::TreeDescription tree;
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
