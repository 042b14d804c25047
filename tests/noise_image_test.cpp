// Noise that rays add to a volume on their way, beside the same noise in bricks.

#include <gtest/gtest.h>

#include "gvx/produce/amplify_producer.h"
#include "gvx/produce/deeper_producer.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

/// A soft ball, with room for noise around its surface.
double soft_ball(Vec3d p) {
  return std::clamp(1.1 - 2.2 * length(p - Vec3d(0.5, 0.5, 0.5)), 0.0, 1.0);
}

struct Amplified {
  std::shared_ptr<const produce::Producer> bricks, deeper;
  render::View view, marched;  // of the one and of the other

  explicit Amplified(double strength = 0.3) {
    const TestScene scene = analytic_scene("soft_ball", soft_ball, {32, 32, 32}, {1, 1, 1}, 2, 16);
    const auto volume = scene.open();
    produce::AmplifyOptions options{.levels = 2, .strength = strength, .wavelength = 5};
    bricks = produce::AmplifyProducer::create(volume, options).value();
    deeper = produce::DeeperProducer::create(volume, options.levels).value();
    view = scene.view;
    view.width = view.height = 100;
    view.functions[0].opacities = {{0.45, 0}, {0.5, 0.9}};
    marched = view;
    marched.noise = produce::amplification(volume->description(), options);
  }
};

struct Rendered {
  render::Picture picture;
  std::uint64_t bricks;
};

Rendered exact(const std::shared_ptr<const produce::Producer>& producer, const render::View& view,
               const engine::EngineOptions& options = {}, const exec::Device& device = exec::Device::cpu()) {
  const auto engine = engine::Engine::create(device, producer, options).value();
  GVX_CHECK(engine->look(view).ok());
  GVX_CHECK(engine->render_exact().ok());
  return {engine->picture(), engine->statistics().bricks_resident};
}

TEST(NoiseInMarch, looks_like_noise_in_bricks) {
  for (const exec::Device& device : exec::Device::all()) {
    const auto compare = [&](const char* what, auto change, double decibels) {
      Amplified scene;
      change(scene.view), change(scene.marched);
      const Rendered bricks = exact(scene.bricks, scene.view, {}, device);
      const Rendered marched = exact(scene.deeper, scene.marched, {}, device);
      const double found = psnr(marched.picture, bricks.picture);
      std::printf("%s on %s: %.1f dB, %d and %d bricks\n", what, device.name().c_str(), found,
                  int(bricks.bricks), int(marched.bricks));
      EXPECT_GE(found, decibels) << what;
      EXPECT_LE(marched.bricks, 9u);
      EXPECT_GT(bricks.bricks, 4 * marched.bricks);
    };
    const auto near = [](render::View& v) {
      v.camera.eye = v.camera.target + 0.5 * (v.camera.eye - v.camera.target);
    };
    compare("near", near, 36);
    compare(
        "unlit", [&](render::View& v) { near(v), v.lighting.enabled = false; }, 37);
    compare(
        "isosurface", [&](render::View& v) { near(v), v.mode = scene::Mode::isosurface, v.isovalue = 0.5; },
        28);
    compare(
        "maximum", [&](render::View& v) { near(v), v.mode = scene::Mode::maximum; }, 37);
    compare(
        "post", [&](render::View& v) { near(v), v.classification = scene::Classification::post; }, 34);
  }
}

TEST(NoiseInMarch, is_nothing_where_it_has_no_strength) {
  Amplified scene(0);
  // Lit, surfaces are told from what is flat by voxels as they are seen.
  scene.marched.lighting.enabled = false;
  render::View plain = scene.marched;
  plain.noise.reset();
  EXPECT_GE(psnr(exact(scene.deeper, scene.marched).picture, exact(scene.deeper, plain).picture), 80);
  Amplified noisy;
  noisy.marched.lighting.enabled = false;
  EXPECT_LT(psnr(exact(noisy.deeper, noisy.marched).picture, exact(noisy.deeper, plain).picture), 25);
}

TEST(NoiseInMarch, is_the_same_bits_for_every_cache_and_number_of_threads_and_in_a_preview) {
  const Amplified scene;
  const render::Picture first = exact(scene.deeper, scene.marched).picture;
  EXPECT_EQ(exact(scene.deeper, scene.marched, {0, engine::PoolSizes{40, 3}}).picture.rgba, first.rgba);
  EXPECT_EQ(exact(scene.deeper, scene.marched, {}, exec::Device::cpu(5)).picture.rgba, first.rgba);
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.deeper, {}).value();
  ASSERT_TRUE(engine->look(scene.marched).ok());
  for (int frame = 0; frame < 10000 && !engine->converged(); ++frame) {
    ASSERT_TRUE(engine->render_for(std::chrono::milliseconds(10)).ok());
  }
  EXPECT_EQ(engine->picture().rgba, first.rgba);
  engine::EngineOptions one;
  one.one_ray_at_a_time = true;
  EXPECT_GE(psnr(exact(scene.deeper, scene.marched, one).picture, first), 60);
}

TEST(NoiseInMarch, needs_one_channel) {
  Amplified scene;
  const auto two = planar_scene("two", {VoxelType::u8, VoxelContent::scalar, 2}, {soft_ball, soft_ball},
                                {16, 16, 16}, 2, 16);
  const auto engine = engine::Engine::create(exec::Device::cpu(), two.open(), {}).value();
  render::View view = two.view;
  view.noise = scene.marched.noise;
  const Status status = engine->look(view);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("one channel"), std::string::npos);
}

}  // namespace
}  // namespace gvx::tests
