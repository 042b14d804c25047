// What the engine hands out: pictures in the caller's memory, how deep they are, and what it warns of.

#include "gvx/engine/engine.h"

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/produce/field_producer.h"

namespace gvx::engine {
namespace {

using namespace std::chrono_literals;

constexpr double kRadius = 0.3;

float to_ball(Vec3d p) {
  return static_cast<float>(kRadius - length(p - Vec3d(0.5)));  // above 0 inside
}
ValueRange bounds_to_ball(const Box3d& box) {
  const float middle = to_ball(0.5 * (box.minimum + box.maximum));
  const auto reach = static_cast<float>(0.5001 * length(box.maximum - box.minimum));
  return {middle - reach, middle + reach};
}

produce::TreeDescription tree_of_levels(std::uint32_t levels) {
  produce::TreeDescription tree;
  tree.max_level = levels - 1;
  return tree;
}
std::shared_ptr<const produce::Producer> ball() {
  return std::make_shared<produce::FieldProducer>(tree_of_levels(3), to_ball, bounds_to_ball);
}

std::unique_ptr<Engine> engine_of(std::shared_ptr<const produce::Producer> producer,
                                  EngineOptions options = {}) {
  return Engine::create(exec::Device::cpu(2), std::move(producer), options).value();
}

/// Of the ball, from the front; opaque from its surface on.
render::View view_of_ball(scene::Mode mode) {
  render::View view;
  view.width = 64;
  view.height = 48;
  view.mode = mode;
  view.camera = {.eye = {0.5, -1.5, 0.6}, .target = {0.5, 0.5, 0.5}, .up = {0, 0, 1}, .fov_degrees = 30};
  view.functions = {{{{0, {1, 0.5, 0.2}}}, {{0, 0}, {0.002, 1}}, 1e-4, {}}};
  view.level_of_detail = false;
  view.background = {0, 0, 0.25f};
  return view;
}

/// Distances along the view to the ball, by geometry.
std::vector<float> true_depth(const render::View& view) {
  const scene::CameraView camera = scene::make_view(view.camera, view.width, view.height).value();
  std::vector<float> depth;
  for (std::uint32_t y = 0; y < view.height; ++y) {
    for (std::uint32_t x = 0; x < view.width; ++x) {
      const Ray ray = camera.pixel_ray(x, y);
      const Vec3d from = ray.origin - Vec3d(0.5);
      const double along = -dot(from, ray.direction);
      const double square = kRadius * kRadius - dot(from, from) + along * along;
      const double distance = square > 0 ? along - std::sqrt(square) : INFINITY;
      depth.push_back(static_cast<float>(distance * dot(ray.direction, camera.forward)));
    }
  }
  return depth;
}

/// Compares depths but for a few pixels at the ball's rim.
void expect_depth(const std::vector<float>& depth, const std::vector<float>& right, float most) {
  ASSERT_EQ(depth.size(), right.size());
  int wrong = 0, finite = 0;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    finite += right[i] < INFINITY ? 1 : 0;
    if (depth[i] == right[i] || std::fabs(depth[i] - right[i]) <= most) continue;
    ++wrong;
  }
  EXPECT_GT(finite, 300);
  EXPECT_LE(wrong, finite / 25);
}

std::vector<float> depth_of(Engine& engine, const render::View& view) {
  std::vector<float> depth(std::size_t{view.width} * view.height);
  const Status status = engine.picture({.depth = {depth}});
  EXPECT_TRUE(status.ok());
  return depth;
}

TEST(EnginePicture, in_the_callers_memory_is_the_picture) {
  const auto engine = engine_of(ball());
  const render::View view = view_of_ball(scene::Mode::composite);
  ASSERT_TRUE(engine->look(view).ok());
  for (const bool exact : {false, true}) {
    ASSERT_TRUE((exact ? engine->render_exact() : engine->render_for(1ms)).ok());
    const render::Picture picture = engine->picture();
    std::vector<std::uint8_t> bytes(picture.rgba.size());
    std::vector<float> floats(picture.rgba.size());
    ASSERT_TRUE(engine->picture({.rgba8 = {bytes}, .rgba = {floats}}).ok());
    EXPECT_EQ(bytes, picture.to_8_bit());
    EXPECT_EQ(floats, picture.rgba);
  }
}

TEST(EnginePicture, what_does_not_fit_or_has_no_depth_is_an_error) {
  const auto engine = engine_of(ball());
  render::View view = view_of_ball(scene::Mode::maximum);
  ASSERT_TRUE(engine->look(view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  std::vector<float> values(64 * 48);
  EXPECT_EQ(engine->picture({.depth = {values}}).error().message,
            "picture: depth: only modes composite and isosurface have one");
  EXPECT_EQ(engine->picture({.rgba = {values}}).error().message,
            "picture: rgba: 3072 values with rows 256 apart do not hold 48 rows of 256");
}

TEST(EnginePicture, depth_is_where_the_surface_is) {
  for (const scene::Mode mode : {scene::Mode::isosurface, scene::Mode::composite}) {
    render::View view = view_of_ball(mode);
    const auto engine = engine_of(ball());
    for (const bool orthographic : {false, true}) {
      view.camera.height_world = orthographic ? 1.1 : 0;
      view.antialias = orthographic ? 2 : 1;
      ASSERT_TRUE(engine->look(view).ok());
      ASSERT_TRUE(engine->render_exact().ok());
      // A surface is found to a small part of a voxel; a step that enters matter is half a voxel long.
      const float most = mode == scene::Mode::isosurface ? 0.05f / 64 : 0.6f / 64;
      expect_depth(depth_of(*engine, view), true_depth(view), most);
    }
  }
}

TEST(EnginePicture, depth_of_a_preview_is_of_what_it_shows) {
  const render::View view = view_of_ball(scene::Mode::isosurface);
  const auto engine = engine_of(ball());
  ASSERT_TRUE(engine->look(view).ok());
  ASSERT_TRUE(engine->render_for(1ns).ok());
  ASSERT_FALSE(engine->converged());
  // The root's voxels alone, a 16th wide.
  const std::vector<float> depth = depth_of(*engine, view);
  const auto middle = depth[24 * 64 + 32];
  EXPECT_NEAR(middle, true_depth(view)[24 * 64 + 32], 1.0 / 16);
}

TEST(EnginePicture, depth_in_haze_is_where_half_of_it_is_passed) {
  // Matter of one value, so that nodes are constant: no brick is made.
  const auto producer = std::make_shared<produce::FieldProducer>(
      tree_of_levels(3), [](Vec3d) { return 1.0f; },
      [](const Box3d&) {
        return ValueRange{1, 1};
      });
  render::View view = view_of_ball(scene::Mode::composite);
  view.camera.eye = {0.5, -1, 0.5};
  view.camera.height_world = 0.5;
  view.functions = {{{{0, {1, 1, 1}}}, {{0, 0.9}}, 1, {}}};  // 0.9 of what passes a unit's length
  const auto engine = engine_of(producer);
  ASSERT_TRUE(engine->look(view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  const double half = 1 + std::log(0.5) / std::log(0.1);
  for (const float depth : depth_of(*engine, view)) ASSERT_NEAR(depth, half, 1e-3);
  view.functions[0].opacities = {{0, 0.3}};  // never half
  ASSERT_TRUE(engine->look(view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  for (const float depth : depth_of(*engine, view)) ASSERT_EQ(depth, INFINITY);
}

/// Bounds hold only what lies lower than 0.05.
std::shared_ptr<const produce::Producer> liar() {
  return std::make_shared<produce::FieldProducer>(tree_of_levels(3), to_ball, [](const Box3d& box) {
    const ValueRange right = bounds_to_ball(box);
    return ValueRange{std::fmin(right.minimum, 0.05f), std::fmin(right.maximum, 0.05f)};
  });
}

TEST(EngineWarnings, a_brick_beyond_its_bounds_is_reported_once) {
  for (const bool exact : {true, false}) {
    std::vector<std::string> warnings;
    EngineOptions options;
    options.warn = [&](const std::string& line) { warnings.push_back(line); };
    const auto engine = engine_of(liar(), options);
    const render::View view = view_of_ball(scene::Mode::composite);
    ASSERT_TRUE(engine->look(view).ok());
    ASSERT_TRUE((exact ? engine->render_exact() : engine->render_for(1ns)).ok());
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0].find("producer: the brick of node ("), 0u) << warnings[0];
    EXPECT_NE(warnings[0].find(" to 0.05"), std::string::npos) << warnings[0];
    EXPECT_GE(engine->statistics().bricks_beyond_bounds, 1u);
    ASSERT_TRUE(engine->render_exact().ok());
    EXPECT_EQ(warnings.size(), 1u);
  }
  const auto silent = engine_of(liar());  // counts without anyone to tell
  ASSERT_TRUE(silent->look(view_of_ball(scene::Mode::composite)).ok());
  ASSERT_TRUE(silent->render_exact().ok());
  EXPECT_GE(silent->statistics().bricks_beyond_bounds, 1u);
}

TEST(EngineWarnings, right_bounds_are_not_reported) {
  EngineOptions options;
  options.warn = [](const std::string& line) { FAIL() << line; };
  const auto engine = engine_of(ball(), options);
  ASSERT_TRUE(engine->look(view_of_ball(scene::Mode::composite)).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  EXPECT_EQ(engine->statistics().bricks_beyond_bounds, 0u);
}

}  // namespace
}  // namespace gvx::engine
