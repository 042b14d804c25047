// Exact pictures are right, and depend on nothing but the view: compared with the brute-force reference, and
// with themselves for other bricks, caches and threads.

#include <gtest/gtest.h>

#include "test_scenes.h"

namespace gvx::tests {
namespace {

constexpr double kNeededDecibels = 45;
constexpr double kReferenceSamples = 16;

void expect_right(TestScene scene, const char* what) {
  scene.view.level_of_detail = false;
  const ReferencePicture reference = render_reference(scene.volume, scene.view, kReferenceSamples);
  for (const exec::Device& device : exec::Device::all()) {
    const double decibels = psnr(render_exact(scene, device), reference.picture);
    EXPECT_GE(decibels, kNeededDecibels) << what << " on " << device.name();
    std::printf("%-56s %5.1f dB on %s\n", what, decibels, device.name().c_str());
  }
}

struct Shape {
  std::uint32_t n, m;
};
class EveryShape : public testing::TestWithParam<Shape> {};
INSTANTIATE_TEST_SUITE_P(Exact, EveryShape,
                         testing::Values(Shape{2, 8}, Shape{2, 16}, Shape{2, 32}, Shape{3, 8}, Shape{3, 16},
                                         Shape{3, 32}),
                         [](const auto& tested) {
                           return "N" + std::to_string(tested.param.n) + "_M" +
                                  std::to_string(tested.param.m);
                         });

TEST_P(EveryShape, equals_the_reference) {
  const auto [n, m] = GetParam();
  expect_right(analytic_scene("ball", ball, {70, 61, 50}, {1, 1, 1}, n, m), "ball");
  expect_right(analytic_scene("waves", waves, {64, 64, 64}, {1, 1, 1}, n, m), "waves");
}

TEST(Exact, equals_the_reference_in_every_way_to_look) {
  const TestScene scene = analytic_scene("ways", ball, {80, 60, 40}, {0.7, 1, 1.6}, 2, 16);
  const auto variant = [&](const char* what, auto change) {
    TestScene changed = scene;
    change(changed.view);
    expect_right(changed, what);
  };
  variant("anisotropic spacing", [](auto&) {});
  variant("unlit", [](auto& v) { v.lighting.enabled = false; });
  variant("orthographic", [](auto& v) { v.camera.height_world = 90; });
  variant("clipped", [](auto& v) { v.clip = {{0.1, 0.45, 0.2}, {0.9, 1.2, 0.77}}; });
  variant("from within", [](auto& v) { v.camera.eye = v.camera.target + Vec3d(2, 3, 4); });
  variant("opaque surface", [](auto& v) { v.functions[0].opacities = {{0.42, 0}, {0.55, 0.9}}; });
  variant("in world units of opacity", [](auto& v) { v.functions[0].unit_distance = 5; });
  variant("along an axis", [](auto& v) { v.camera.eye = v.camera.target + Vec3d(0, -200, 0); });
}

TEST(Exact, equals_the_reference_on_real_volumes) {
  int tested = 0;
  // The last is an ultrasound, all speckle: its values swing through the function between two samples.
  for (const char* file :
       {"volumes/nifti/osv_engine.nii.gz", "volumes/metaimage/HeadMRVolume.mha",
        "volumes/niivue_formats/MNI152_2009_template.nii.gz", "volumes/nrrd/itk_Input-RA-Short.nrrd"}) {
    if (test_data(file).empty()) continue;
    ++tested;
    auto scene = file_scene(file, 16);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    expect_right(scene.value(), file);
  }
  if (tested == 0) GTEST_SKIP() << "GVX_TEST_DATA is not set, or has no volumes";
}

TEST(Exact, brick_size_and_arity_leave_no_trace) {
  // Seams at brick faces would differ between brick sizes.
  TestScene scene = analytic_scene("seams8", waves, {75, 66, 57}, {1, 1, 1}, 2, 8);
  scene.view.level_of_detail = false;
  const render::Picture first = render_exact(scene);
  for (const Shape shape : {Shape{2, 16}, Shape{2, 32}, Shape{3, 8}}) {
    scene.store_path = analytic_scene("seams", waves, {75, 66, 57}, {1, 1, 1}, shape.n, shape.m).store_path;
    EXPECT_GE(psnr(render_exact(scene), first), 90) << shape.n << ' ' << shape.m;
  }
}

TEST(Exact, brick_size_leaves_no_trace_in_noise_lit_and_far) {
  // Noise is steep at every face: a gradient or a deviation that a brick's border cuts short would show.
  const auto noise = [](Vec3d p) {
    const double waves =
        std::sin(417 * p.x + 311 * p.y) * std::sin(529 * p.z) * std::sin(283 * p.y + 71 * p.x);
    return 0.5 + 0.5 * waves;
  };
  TestScene scene = analytic_scene("noise8", noise, {75, 66, 57}, {1, 1, 1}, 2, 8);
  scene.view.functions[0].opacities = {{0.5, 0}, {0.6, 0.7}};  // and a steep function lights where it is seen
  const scene::Camera near = scene.view.camera;
  for (const double away : {1.0, 4.0}) {
    scene.view.camera.eye = near.target + away * (near.eye - near.target);
    std::vector<render::Picture> pictures;
    for (const std::uint32_t m : {8u, 16u, 32u}) {
      scene.store_path = analytic_scene("noise", noise, {75, 66, 57}, {1, 1, 1}, 2, m).store_path;
      pictures.push_back(render_exact(scene));
    }
    EXPECT_GE(psnr(pictures[0], pictures[1]), 115) << away;
    EXPECT_GE(psnr(pictures[0], pictures[2]), 115) << away;
  }
}

/// Pools from comfortable down to two bricks.
std::vector<engine::EngineOptions> pools() {
  std::vector<engine::EngineOptions> options = {{1ull << 30, {}}, {32ull << 20, {}}};
  for (const engine::PoolSizes sizes :
       {engine::PoolSizes{4096, 60}, engine::PoolSizes{400, 20}, engine::PoolSizes{150, 6}}) {
    options.push_back({0, sizes});
  }
  return options;
}

TEST(Exact, is_the_same_bits_for_every_cache_and_every_number_of_threads) {
  for (const bool lod : {false, true}) {
    TestScene scene = analytic_scene("bits", waves, {90, 80, 70}, {1, 1, 1}, 2, 8);
    scene.view.level_of_detail = lod;
    const render::Picture first = render_exact(scene);
    std::uint64_t evicted = 0;
    for (const engine::EngineOptions& options : pools()) {
      for (const int threads : {1, 2, 5}) {
        engine::Statistics statistics;
        const render::Picture picture = render_exact(scene, exec::Device::cpu(threads), options, &statistics);
        EXPECT_EQ(picture.rgba, first.rgba) << "bricks " << (options.pools ? options.pools->bricks : 0);
        EXPECT_TRUE(statistics.converged);
        if (options.pools) {
          EXPECT_LE(statistics.bricks_resident, options.pools->bricks);
        }
        evicted += statistics.bricks_evicted;
      }
    }
    EXPECT_GT(evicted, 1000u);
  }
}

TEST(Exact, needs_no_more_than_two_bricks) {
  // A ray in the cone's blend of two levels needs a brick and its parent's at once.
  TestScene scene = analytic_scene("two", waves, {60, 50, 40}, {1, 1, 1}, 2, 8);
  scene.view.width = 24;
  scene.view.height = 18;
  const render::Picture picture = render_exact(scene, exec::Device::cpu(), {0, engine::PoolSizes{40, 2}});
  EXPECT_EQ(picture.rgba, render_exact(scene).rgba);
}

TEST(Exact, loads_little_more_than_rays_need) {
  TestScene scene = analytic_scene("need", ball, {120, 120, 120}, {1, 1, 1}, 2, 8);
  scene.view.level_of_detail = false;
  const ReferencePicture reference = render_reference(scene.volume, scene.view, 4, 8);
  engine::Statistics statistics;
  render_exact(scene, exec::Device::cpu(), {}, &statistics);
  const double ratio = static_cast<double>(statistics.bricks_produced) /
                       static_cast<double>(reference.necessary_bricks.size());
  EXPECT_LT(ratio, 1.5);
  EXPECT_GE(ratio, 1.0);
}

TEST(Exact, a_change_of_function_reloads_nothing) {
  TestScene scene = analytic_scene("reclassify", waves, {90, 80, 70}, {1, 1, 1}, 2, 8);
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value();
  const render::View narrow = [&] {
    render::View v = scene.view;
    v.functions[0].opacities = {{0.6, 0}, {0.8, 0.3}};
    return v;
  }();
  ASSERT_TRUE(engine->look(scene.view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  const render::Picture wide_picture = engine->picture();
  ASSERT_TRUE(engine->look(narrow).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  const render::Picture narrow_picture = engine->picture();
  ASSERT_TRUE(engine->look(scene.view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  EXPECT_EQ(engine->statistics().bricks_produced, 0u);
  EXPECT_EQ(engine->picture().rgba, wide_picture.rgba);
  engine->residency().check_invariants();
  scene.view = narrow;
  EXPECT_EQ(render_exact(scene).rgba, narrow_picture.rgba);
}

TEST(Exact, level_of_detail_far_away_loads_coarse_bricks_only) {
  TestScene scene = analytic_scene("far", ball, {128, 128, 128}, {1, 1, 1}, 2, 8);
  engine::Statistics near, far;
  render_exact(scene, exec::Device::cpu(), {}, &near);
  scene.view.camera.eye =
      scene.view.camera.target + 40.0 * (scene.view.camera.eye - scene.view.camera.target);
  render_exact(scene, exec::Device::cpu(), {}, &far);
  EXPECT_LE(far.bricks_produced, 8u);
  EXPECT_GT(near.bricks_produced, 500u);
}

TEST(Exact, flat_means_of_a_sparse_volume_hide_nothing) {
  // Single bright voxels average to one value at coarse levels; the detail must come whatever was looked at
  // before.
  TestScene scene = analytic_scene(
      "sparse",
      [](Vec3d p) {
        const auto on = [](double v) { return static_cast<int>(v * 64) % 8 == 3; };
        return on(p.x) && on(p.y) && on(p.z) ? 1.0 : 0.0;
      },
      {64, 64, 64}, {1, 1, 1}, 2, 8);
  scene.view.functions[0].opacities = {{0, 0}, {1, 0.9}};
  const render::Picture cold = render_exact(scene);
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value();
  render::View far = scene.view;
  far.camera.eye = far.camera.target + 20.0 * (far.camera.eye - far.camera.target);
  ASSERT_TRUE(engine->look(far).ok());
  ASSERT_TRUE(engine->render_for(std::chrono::milliseconds(50)).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  engine->residency().check_invariants();
  ASSERT_TRUE(engine->look(scene.view).ok());
  ASSERT_TRUE(engine->render_for(std::chrono::milliseconds(50)).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  engine->residency().check_invariants();
  EXPECT_EQ(engine->picture().rgba, cold.rgba);
}

TEST(Exact, pools_that_hold_no_path_are_an_error_and_no_hang) {
  const TestScene scene = analytic_scene("hopeless", waves, {90, 80, 70}, {1, 1, 1}, 2, 8);
  for (const engine::PoolSizes sizes :
       {engine::PoolSizes{3, 2}, engine::PoolSizes{6, 1}, engine::PoolSizes{6, 2}}) {
    const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {0, sizes});
    if (!engine.ok()) {
      EXPECT_NE(engine.error().message.find("memory"), std::string::npos);
      continue;
    }
    ASSERT_TRUE(engine.value()->look(scene.view).ok());
    const Status status = engine.value()->render_exact();
    if (!status.ok()) {
      EXPECT_NE(status.error().message.find("memory"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace gvx::tests
