// The sponge: recursion in the tree, as deep as a tree may be.

#include <gtest/gtest.h>

#include "gvx/produce/sponge_producer.h"
#include "gvx/scene/transfer_presets.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

using produce::SpongeProducer;

TEST(Sponge, is_shown_from_one_brick_at_any_depth) {
  const auto sponge = std::make_shared<produce::SpongeProducer>(8);
  const auto engine = engine::Engine::create(exec::Device::cpu(), sponge, {}).value();
  render::View view;
  view.width = view.height = 96;
  view.functions = {scene::preset("solid", {0, 255, {}}).value()};
  for (const double distance : {2.0, 1e-2, 1e-5}) {
    // Down the middle of a corner edge, which is solid at every depth.
    view.camera = {Vec3d(-1, -1.3, 1.1) * distance, {0, 0, 0}, {0, 0, 1}, 40, 0};
    ASSERT_TRUE(engine->look(view).ok());
    ASSERT_TRUE(engine->render_exact().ok());
    const engine::Statistics s = engine->statistics();
    EXPECT_EQ(s.bricks_resident, 1u);
    EXPECT_EQ(s.nodes_resident, 28u);
    double lit = 0;
    const render::Picture picture = engine->picture();
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4) lit += picture.rgba[i] > 0.1f ? 1 : 0;
    EXPECT_GT(lit, 500) << distance;
    // The walls of holes are darker than the outside at every depth.
    view.lighting.enabled = false;
    ASSERT_TRUE(engine->look(view).ok());
    ASSERT_TRUE(engine->render_exact().ok());
    EXPECT_LT(psnr(picture, engine->picture()), 22) << distance;
    view.lighting.enabled = true;
  }
}

TEST(Sponge, is_the_same_seen_from_a_third_of_the_way) {
  // Self-similarity: a third of the distance, a third of the cube, the same picture up to the rounding of
  // levels.
  const auto sponge = std::make_shared<produce::SpongeProducer>(8);
  const auto engine = engine::Engine::create(exec::Device::cpu(), sponge, {}).value();
  render::View view;
  view.width = view.height = 96;
  view.functions = {scene::preset("solid", {0, 255, {}}).value()};
  view.camera = {{-1.5, -2, 1.7}, {0.1, 0.1, 0.1}, {0, 0, 1}, 12, 0};
  ASSERT_TRUE(engine->look(view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  const render::Picture whole = engine->picture();
  view.camera.eye = view.camera.eye / 3.0;
  view.camera.target = view.camera.target / 3.0;
  view.clip = {{0, 0, 0}, {1.0 / 3, 1.0 / 3, 1.0 / 3}};
  ASSERT_TRUE(engine->look(view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  EXPECT_GE(psnr(engine->picture(), whole), 30);
}

/// Towards (1/4, 1/4, 1/2), whose digits to base 3 are 02 02.., 02 02.., 11 11..: the sponge around it is the
/// same nine times nearer, whatever else there is far away.
render::View dive(int nines, std::uint32_t pixels) {
  render::View view;
  view.width = view.height = pixels;
  // Opaque or not: how far light comes through what is between would depend on how large a voxel is.
  view.functions = {scene::preset("solid", {0, 255, {}}).value()};
  // What is half way between air and matter is opaque, however it is rounded.
  view.functions[0].opacities = {{127.3, 0}, {127.4, 1}};
  const double near = std::pow(9.0, -nines);
  view.camera = {near * Vec3d(-3.1, -2.3, 1.1), {0, 0, 0}, {0, 0, 1}, 40, 0, Vec3dd(0.25, 0.25, 0.5)};
  return view;
}

std::unique_ptr<engine::Engine> sponge_engine(SpongeProducer::Nodes nodes, bool one_ray_at_a_time = false,
                                              const exec::Device& device = exec::Device::cpu()) {
  engine::EngineOptions options;
  options.one_ray_at_a_time = one_ray_at_a_time;
  return engine::Engine::create(device, std::make_shared<SpongeProducer>(16, nodes), options).value();
}

render::Picture exact(engine::Engine& engine, const render::View& view) {
  GVX_CHECK(engine.look(view).ok());
  GVX_CHECK(engine.render_exact().ok());
  return engine.picture();
}

TEST(DeepSponge, looks_and_costs_the_same_34_levels_down) {
  for (const exec::Device& device : exec::Device::all()) {
    const auto engine = sponge_engine(SpongeProducer::Nodes::shared, false, device);
    const render::Picture near = exact(*engine, dive(3, 128));
    const auto samples = double(engine->statistics().samples);
    // At 9^17 = 3^34 pixels resolve the finest level, 3^40 nodes of 16 voxels.
    for (const int nines : {4, 9, 13, 16, 17}) {
      const render::Picture deep = exact(*engine, dive(nines, 128));
      // So steep a function tells apart how places far down are rounded.
      EXPECT_GE(psnr(deep, near), nines > 9 ? 45 : 150) << nines << " on " << device.name();
      EXPECT_NEAR(double(engine->statistics().samples) / samples, 1, nines < 17 ? 0.01 : 0.05) << nines;
      EXPECT_EQ(engine->statistics().bricks_resident, 1u);
      std::printf("3^-%d: %.1f dB, %.4f of the samples\n", 2 * nines, psnr(deep, near),
                  double(engine->statistics().samples) / samples);
    }
  }
}

TEST(DeepSponge, does_not_jitter) {
  // A camera that moves by a tenth of a pixel: at every depth the picture changes by as much.
  const auto engine = sponge_engine(SpongeProducer::Nodes::shared);
  const auto change = [&](int nines, double pixels) {
    render::View view = dive(nines, 96);
    const render::Picture before = exact(*engine, view);
    const double aside = pixels * length(view.camera.eye) * 2 * std::tan(20 * M_PI / 180) / 96;
    view.camera.eye = view.camera.eye + Vec3d(0, 0, aside);
    view.camera.target = view.camera.target + Vec3d(0, 0, aside);
    return psnr(exact(*engine, view), before);
  };
  for (const double pixels : {0.01, 0.1, 0.5}) {
    const double shallow = change(3, pixels);
    for (const int nines : {8, 13, 16}) EXPECT_NEAR(change(nines, pixels), shallow, 0.3) << nines;
  }
}

TEST(DeepSponge, is_the_same_one_ray_at_a_time) {
  const auto vectors = sponge_engine(SpongeProducer::Nodes::shared);
  const auto scalar = sponge_engine(SpongeProducer::Nodes::shared, true);
  for (const int nines : {2, 16}) {
    EXPECT_GE(psnr(exact(*vectors, dive(nines, 24)), exact(*scalar, dive(nines, 24))), 60) << nines;
  }
}

TEST(DeepSponge, is_the_same_of_stored_nodes) {
  const auto shared = sponge_engine(SpongeProducer::Nodes::shared);
  const auto stored = sponge_engine(SpongeProducer::Nodes::stored);
  for (const int nines : {0, 16}) {
    const render::View view = dive(nines, 32);
    EXPECT_EQ(exact(*shared, view).rgba, exact(*stored, view).rgba) << nines;
    EXPECT_GT(stored->statistics().bricks_resident, 10u);
    stored->residency().check_invariants();
  }
}

TEST(DeepSponge, previews_come_to_the_exact_picture) {
  const auto engine = sponge_engine(SpongeProducer::Nodes::shared);
  const render::Picture right = exact(*engine, dive(16, 48));
  const auto again = sponge_engine(SpongeProducer::Nodes::shared);
  ASSERT_TRUE(again->look(dive(16, 48)).ok());
  for (int frame = 0; frame < 10000 && !again->converged(); ++frame) {
    ASSERT_TRUE(again->render_for(std::chrono::milliseconds(20)).ok());
  }
  ASSERT_TRUE(again->converged());
  EXPECT_EQ(again->picture().rgba, right.rgba);
}

}  // namespace
}  // namespace gvx::tests
