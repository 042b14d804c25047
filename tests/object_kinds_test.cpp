/// \file
/// Volumes of every kind beside others: labels, colours, several channels, added noise, lights and every
/// classification.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/engine/cache.h"
#include "gvx/engine/viewer.h"
#include "gvx/engine/world.h"
#include "gvx/scene/label_table.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

/// A scene's volume, and what is beside it.
struct Company {
  std::vector<TestScene> scenes;  // the first one's view has the camera
  bool one_ray_at_a_time = false;
};

render::Picture render(const Company& company) {
  engine::CacheOptions options;
  const auto cache = engine::Cache::create(exec::Device::cpu(2), options).value();
  std::vector<engine::Object> objects;
  for (std::size_t i = 0; i < company.scenes.size(); ++i) {
    Affine3 place;
    place.origin = Vec3d(1.5, -2.25, 0.75) * double(i);
    objects.push_back({cache->open(company.scenes[i].open()).value(), place, company.scenes[i].view});
  }
  engine::ViewerOptions how;
  how.one_ray_at_a_time = company.one_ray_at_a_time;
  engine::Viewer viewer(cache, how);
  const auto world = engine::World::make(std::move(objects)).value();
  EXPECT_TRUE(viewer.look(company.scenes[0].view, world).ok());
  const Status done = viewer.render_exact();
  EXPECT_TRUE(done.ok()) << done.error().message;
  return viewer.picture();
}

/// A ball of another size in about the same place.
TestScene ball_of(double opacity) {
  TestScene scene = analytic_scene("companion", ball, {40, 40, 40}, {1, 1, 1}, 2, 8);
  scene.view.functions = {{{{0, {0.2, 0.4, 1}}}, {{0.2, 0}, {1, opacity}}, 4, {}}};
  return scene;
}

/// Beside an object that shows nothing a volume is what it is alone; beside one that it overlaps, tiles of
/// rays show what rays do one by one.
void expect_good_company(TestScene scene, const std::string& what) {
  scene.view.width = 96;
  scene.view.height = 80;
  const render::Picture alone = render({{scene}});
  const double unseen = psnr(alone, render({{scene, ball_of(0)}}));
  const render::Picture both = render({{scene, ball_of(0.2)}});
  const double alike = psnr(both, render({{scene, ball_of(0.2)}, true}));
  const double changed = psnr(both, alone);
  std::printf("%-28s %6.1f dB to alone, %6.1f dB to one ray at a time, %4.1f dB that the other changes\n",
              what.c_str(), unseen, alike, changed);
  EXPECT_GE(unseen, 55) << what;
  EXPECT_GE(alike, 80) << what;
  EXPECT_LT(changed, 45) << what << ": the other is not seen";
}

Field scaled(double (*field)(Vec3d), double by) {
  return [=](Vec3d p) { return by * field(p); };
}

TEST(ObjectKinds, scalars_of_every_mode_lit_and_classified) {
  const TestScene scene = analytic_scene("kinds", ball, {44, 40, 36}, {1, 1, 1}, 2, 8);
  const auto variant = [&](const char* what, auto change) {
    TestScene changed = scene;
    change(changed.view);
    expect_good_company(changed, what);
  };
  variant("translucent, unlit", [](auto& v) { v.lighting.enabled = false; });
  variant("lit", [](auto& v) { v.lighting.enabled = true; });
  variant("two lights", [](auto& v) {
    v.lighting.lights = 2;
    v.lighting.light[0] = {scene::LightKind::directional, {1, 2, -3}, {1, 0.9f, 0.8f}};
    v.lighting.light[1] = {scene::LightKind::point, {20, -30, 18}, {0.2f, 0.3f, 0.8f}};
  });
  variant("post-classified", [](auto& v) { v.classification = scene::Classification::post; });
  variant("noise", [](auto& v) {
    v.noise = AddedNoise{};
    v.noise->strength = 0.1f;
  });
  variant("maximum", [](auto& v) { v.mode = scene::Mode::maximum; });
  variant("mean", [](auto& v) { v.mode = scene::Mode::mean; });
  variant("isosurface", [](auto& v) {
    v.mode = scene::Mode::isosurface;
    v.isovalue = 0.7;
  });
}

TEST(ObjectKinds, channels_labels_and_colours) {
  TestScene scene = planar_scene("kinds_two", {VoxelType::u8, VoxelContent::scalar, 2},
                                 {scaled(ball, 255), scaled(waves, 255)}, {44, 40, 36}, 2, 8);
  scene.view.functions = {{{{0, {1, 0.3, 0}}}, {{60, 0}, {255, 0.2}}, 3, {}},
                          {{{0, {0, 1, 0.3}}}, {{150, 0}, {255, 0.1}}, 3, {}}};
  expect_good_company(scene, "two channels");
  const auto regions = [](Vec3d p) {
    return length(p - Vec3d(0.5)) > 0.45 ? 0.0 : std::floor(p.x * 4) + 4 * std::floor(p.y * 2) + 1;
  };
  scene =
      planar_scene("kinds_labels", {VoxelType::u16, VoxelContent::labels, 1}, {regions}, {44, 40, 36}, 2, 8);
  scene.view.functions = {scene::label_colors(9)};
  scene.view.functions[0].opacities = {{0, 0}, {0.5, 0}, {0.5, 0.15}};
  expect_good_company(scene, "labels");
  const auto opacity = [](Vec3d p) { return 0.3 * ball(p); };
  const auto color = [&](double value) {
    return [=](Vec3d p) { return std::round(255 * value * opacity(p)); };
  };
  scene = planar_scene("kinds_colors", {VoxelType::u8, VoxelContent::color, 4},
                       {color(1), color(0.5), color(0.2), color(1)}, {44, 40, 36}, 2, 8);
  scene.view.functions.clear();
  expect_good_company(scene, "colours");
}

}  // namespace
}  // namespace gvx::tests
