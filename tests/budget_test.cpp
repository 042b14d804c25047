// Budget mode always shows something, says how far it is, and comes to rest at the exact picture.

#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "test_scenes.h"

namespace gvx::tests {
namespace {

using namespace std::chrono_literals;

TestScene scene_of(const char* name) {
  return analytic_scene(name, waves, {90, 80, 70}, {1, 1, 1}, 2, 8);
}

TEST(Budget, the_first_frame_shows_the_whole_volume) {
  TestScene scene = scene_of("first");
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value();
  ASSERT_TRUE(engine->look(scene.view).ok());
  ASSERT_TRUE(engine->render_for(30ms).ok());
  EXPECT_GE(psnr(engine->picture(), render_exact(scene)), 15);
  const engine::Statistics statistics = engine->statistics();
  EXPECT_GE(statistics.bricks_resident, 1u);
}

TEST(Budget, shows_something_even_in_no_time_at_all) {
  TestScene scene = scene_of("no_time");
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value();
  ASSERT_TRUE(engine->look(scene.view).ok());
  ASSERT_TRUE(engine->render_for(1ns).ok());
  // The root's brick alone may be all there was time for: far from right, but not nothing.
  const render::Picture shown = engine->picture(), exact = render_exact(scene);
  EXPECT_GE(psnr(shown, exact), 12);
  scene.view.functions[0].opacities = {{0, 0}};
  EXPECT_LT(psnr(shown, render_exact(scene)), 20);
}

TEST(Budget, comes_to_rest_in_frames_shorter_than_any_stage_of_the_preview) {
  TestScene scene = scene_of("short");
  const auto engine = engine::Engine::create(exec::Device::cpu(1), scene.open(), {}).value();
  ASSERT_TRUE(engine->look(scene.view).ok());
  for (int frame = 0; frame < 200000 && !engine->converged(); ++frame)
    ASSERT_TRUE(engine->render_for(100us).ok());
  ASSERT_TRUE(engine->converged());
  EXPECT_EQ(engine->picture().rgba, render_exact(scene).rgba);
}

TEST(Budget, comes_to_rest_at_the_exact_picture_whatever_the_cache) {
  for (const engine::EngineOptions& options :
       {engine::EngineOptions{1ull << 30, {}}, engine::EngineOptions{0, engine::PoolSizes{4096, 60}},
        engine::EngineOptions{0, engine::PoolSizes{400, 9}}}) {
    TestScene scene = scene_of("rest");
    const render::Picture exact = render_exact(scene);
    const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), options).value();
    ASSERT_TRUE(engine->look(scene.view).ok());
    int frames = 0;
    while (!engine->statistics().converged && frames < 3000) {
      ASSERT_TRUE(engine->render_for(10ms).ok());
      ASSERT_TRUE(engine->look(scene.view).ok());  // the same view does not start again
      ++frames;
    }
    const engine::Statistics statistics = engine->statistics();
    ASSERT_TRUE(statistics.converged) << (options.pools ? options.pools->bricks : 0);
    EXPECT_EQ(statistics.resident_share, 1.0);
    EXPECT_EQ(engine->picture().rgba, exact.rgba);
    engine->residency().check_invariants();
  }
}

TEST(Budget, a_moving_camera_keeps_showing_and_ends_exact) {
  TestScene scene = scene_of("move");
  const auto engine =
      engine::Engine::create(exec::Device::cpu(), scene.open(), {0, engine::PoolSizes{4096, 100}}).value();
  for (int frame = 0; frame < 20; ++frame) {
    scene.view.camera.eye = scene.view.camera.eye + Vec3d(4, 1, -2);
    ASSERT_TRUE(engine->look(scene.view).ok());
    ASSERT_TRUE(engine->render_for(8ms).ok());
    const render::Picture picture = engine->picture();
    double lit = 0;
    for (std::size_t i = 0; i < picture.rgba.size(); i += 4) lit += picture.rgba[i] > 0.15f ? 1 : 0;
    EXPECT_GT(lit, 1000) << frame;
  }
  ASSERT_TRUE(engine->render_exact().ok());
  EXPECT_EQ(engine->picture().rgba, render_exact(scene).rgba);
}

TEST(Budget, coarser_levels_are_for_moving_cameras_that_miss_their_budget_and_leave_no_trace) {
  TestScene scene = scene_of("adapt");
  const scene::Camera near = scene.view.camera;
  render::Picture moving[2];
  for (const bool adapts : {false, true}) {
    scene::Camera& camera = scene.view.camera;
    camera.eye = near.eye;
    engine::EngineOptions options;
    options.adapt_levels = adapts;
    const auto engine = engine::Engine::create(exec::Device::cpu(1), scene.open(), options).value();
    ASSERT_TRUE(engine->look(scene.view).ok());
    ASSERT_TRUE(engine->render_exact().ok());
    for (int frame = 0; frame < 8; ++frame) {
      camera.eye = camera.eye + Vec3d(0.1, 0, 0);
      ASSERT_TRUE(engine->look(scene.view).ok());
      ASSERT_TRUE(engine->render_for(0ms).ok());
    }
    EXPECT_EQ(engine->statistics().level_bias, adapts ? 1 : 0);
    moving[adapts ? 1 : 0] = engine->picture();
    for (int frame = 0; frame < 10000 && !engine->converged(); ++frame) {
      ASSERT_TRUE(engine->render_for(5ms).ok());
    }
    EXPECT_TRUE(engine->converged());
    EXPECT_EQ(engine->statistics().level_bias, 0);
    EXPECT_EQ(engine->picture().rgba, render_exact(scene).rgba) << adapts;
  }
  EXPECT_NE(moving[0].rgba, moving[1].rgba);
}

TEST(Budget, says_how_much_of_what_it_wants_is_there) {
  TestScene scene = scene_of("share");
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value();
  ASSERT_TRUE(engine->look(scene.view).ok());
  double share = 0;
  bool coarse = false;
  for (int frame = 0; frame < 2000 && !engine->statistics().converged; ++frame) {
    ASSERT_TRUE(engine->render_for(3ms).ok());
    const engine::Statistics s = engine->statistics();
    coarse = coarse || s.worst_lack > 0;
    EXPECT_GE(s.resident_share, 0);
    EXPECT_LE(s.resident_share, 1);
    share = s.resident_share;
  }
  EXPECT_TRUE(coarse);
  EXPECT_EQ(share, 1);
}

TEST(Budget, says_where_its_time_went) {
  TestScene scene = scene_of("stages");
  const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), {}).value();
  const engine::StageTimes opened = engine->statistics().stages;
  ASSERT_TRUE(engine->look(scene.view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  const engine::Statistics cold = engine->statistics();
  const double reading = cold.stages.reading - opened.reading;
  const double decoding = cold.stages.decoding - opened.decoding;
  EXPECT_GT(reading, 0);
  EXPECT_GT(decoding, 0);
  EXPECT_GE(cold.stages.producing, reading + decoding);
  EXPECT_GT(cold.stages.committing, 0);
  const double frame = cold.stages.marching + cold.stages.committing + cold.stages.waiting;
  EXPECT_GT(frame, 0.5 * cold.frame_milliseconds);
  EXPECT_LE(frame, cold.frame_milliseconds);
  // All is there: nothing more is made.
  scene.view.background.x += 0.5f;
  ASSERT_TRUE(engine->look(scene.view).ok());
  ASSERT_TRUE(engine->render_exact().ok());
  const engine::StageTimes warm = engine->statistics().stages;
  EXPECT_EQ(warm.producing, cold.stages.producing);
  EXPECT_GT(warm.marching, cold.stages.marching);
}

TEST(Budget, makes_what_a_moving_camera_will_need_while_it_waits_for_nothing) {
  TestScene scene = scene_of("ahead");
  scene.view.camera.fov_degrees = 6;
  const scene::Camera start = scene.view.camera;
  const auto camera_at = [&](double frame) {
    scene::Camera camera = start;
    const Vec3d way = frame * Vec3d(2, 0, 1);
    camera.eye = camera.eye + way;
    camera.target = camera.target + way;
    return camera;
  };
  std::uint64_t made[2] = {};
  for (const bool prefetch : {false, true}) {
    engine::EngineOptions options;
    options.prefetch = prefetch;
    const auto engine = engine::Engine::create(exec::Device::cpu(), scene.open(), options).value();
    for (int frame = 0; frame < 2; ++frame) {
      scene.view.camera = camera_at(frame);
      ASSERT_TRUE(engine->look(scene.view).ok());
      for (int i = 0; i < 100 && !engine->converged(); ++i) ASSERT_TRUE(engine->render_for(2s).ok());
      ASSERT_TRUE(engine->converged());
      EXPECT_EQ(engine->picture().rgba, render_exact(scene).rgba);
    }
    // What is made for later is taken in by later frames.
    std::uint64_t before = 0;
    for (int still = 0; still < 300; ++still) {
      ASSERT_TRUE(engine->render_for(2s).ok());
      if (engine->residency().resident_bricks() != before) still = 0;
      before = engine->residency().resident_bricks();
      std::this_thread::sleep_for(5ms);
    }
    engine->residency().check_invariants();
    scene.view.camera = camera_at(5);
    ASSERT_TRUE(engine->look(scene.view).ok());
    ASSERT_TRUE(engine->render_exact().ok());
    made[prefetch ? 1 : 0] = engine->statistics().bricks_produced;
    EXPECT_EQ(engine->picture().rgba, render_exact(scene).rgba);
  }
  std::printf("bricks made four frames later: %u, after prefetching %u\n", unsigned(made[0]),
              unsigned(made[1]));
  EXPECT_GT(made[0], 10u);
  // A fifth on an idle machine; on a busy one prefetching ends earlier now and then, at three fifths.
  EXPECT_LE(3 * made[1], 2 * made[0]);
}

/// Of another producer, but for what lies behind x in tree space: that cannot be made.
class Torn final : public produce::Producer {
 public:
  Torn(std::shared_ptr<const produce::Producer> whole, double x) : whole_(std::move(whole)), x_(x) {}
  const produce::TreeDescription& description() const override { return whole_->description(); }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    return whole_->describe(keys, infos);
  }
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    if (corner(key).x / std::exp2(double(key.level)) >= x_) return Error{"torn"};
    return whole_->produce(key, voxels);
  }

 private:
  std::shared_ptr<const produce::Producer> whole_;
  double x_;
};

TEST(Budget, what_is_torn_beside_the_picture_is_no_error) {
  TestScene scene = scene_of("torn");
  scene.view.camera.eye = {10, -300, 35};
  scene.view.camera.target = {10, 40, 35};
  scene.view.camera.fov_degrees = 2;
  const auto torn = std::make_shared<Torn>(scene.open(), 0.25);  // 32 voxels
  const auto engine = engine::Engine::create(exec::Device::cpu(), torn, {}).value();
  for (int frame = 0; frame < 2; ++frame) {  // to the right, where it is torn four frames later
    scene.view.camera.eye.x += 5;
    scene.view.camera.target.x += 5;
    ASSERT_TRUE(engine->look(scene.view).ok());
    for (int i = 0; i < 30; ++i) {
      const Status status = engine->render_for(2s);
      ASSERT_TRUE(status.ok()) << status.error().message;
      std::this_thread::sleep_for(2ms);
    }
    EXPECT_TRUE(engine->converged());
  }
  scene.view.camera.eye.x += 20;
  scene.view.camera.target.x += 20;
  ASSERT_TRUE(engine->look(scene.view).ok());
  EXPECT_FALSE(engine->render_exact().ok());
}

}  // namespace
}  // namespace gvx::tests
