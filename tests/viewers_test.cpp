// Many viewers on one cache: whatever the others do, each one's exact picture is the same bits as alone.

#include <chrono>
#include <cmath>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/engine/viewer.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

using engine::Cache;
using engine::PoolSizes;
using engine::Viewer;
using engine::Volume;
using namespace std::chrono_literals;

TestScene two_viewers_scene() {
  return analytic_scene("viewers", waves, {90, 80, 70}, {1, 1, 1.3}, 2, 8);
}

/// Of the scene, but another camera, size, function, mode or clip box.
render::View random_view(const TestScene& scene, std::mt19937& generator) {
  const auto random = [&] { return std::uniform_real_distribution<double>()(generator); };
  render::View view = scene.view;
  view.width = 40 + static_cast<std::uint32_t>(60 * random());
  view.height = 40 + static_cast<std::uint32_t>(40 * random());
  const Vec3d to_eye = view.camera.eye - view.camera.target;
  const double turn = 2 * M_PI * random(), apart = 0.3 + 1.2 * random();
  view.camera.eye =
      view.camera.target + apart * Vec3d{std::cos(turn) * to_eye.x - std::sin(turn) * to_eye.y,
                                         std::sin(turn) * to_eye.x + std::cos(turn) * to_eye.y, to_eye.z};
  const scene::Mode modes[] = {scene::Mode::composite, scene::Mode::composite, scene::Mode::maximum,
                               scene::Mode::minimum,   scene::Mode::mean,      scene::Mode::isosurface};
  view.mode = modes[static_cast<std::size_t>(6 * random())];
  view.isovalue = 0.3 + 0.4 * random();
  const double from = 0.2 + 0.5 * random();
  view.functions[0].opacities = {{from, 0}, {from + 0.1, 0.2 + 0.6 * random()}, {1, 0.1}};
  if (random() < 0.3) view.clip.minimum.x = 0.4 * random();
  return view;
}

render::Picture alone(const TestScene& scene, const render::View& view) {
  TestScene other = scene;
  other.view = view;
  return render_exact(other);
}

struct Shared {
  std::shared_ptr<Cache> cache;
  std::shared_ptr<Volume> volume;

  Shared(const TestScene& scene, std::optional<PoolSizes> pools, int threads = 2) {
    engine::CacheOptions options;
    options.pools = pools;
    cache = Cache::create(exec::Device::cpu(threads), options).value();
    volume = cache->open(scene.open()).value();
  }
};

TEST(Viewers, with_other_functions_and_cameras_see_what_they_see_alone) {
  const TestScene scene = two_viewers_scene();
  render::View skin = scene.view, dense = scene.view;
  dense.functions[0].opacities = {{0.8, 0}, {0.9, 0.9}};
  dense.camera.eye = dense.camera.target + 0.4 * (dense.camera.eye - dense.camera.target);
  for (const auto& pools : {std::optional<PoolSizes>{}, std::optional(PoolSizes{60, 24})}) {
    const Shared shared(scene, pools);
    Viewer first(shared.cache), second(shared.cache);
    ASSERT_TRUE(first.look(skin, shared.volume).ok());
    ASSERT_TRUE(second.look(dense, shared.volume).ok());
    // By turns, frame by frame, and then to the end.
    for (int frame = 0; frame < 4; ++frame) {
      ASSERT_TRUE(first.render_for(1ms).ok());
      ASSERT_TRUE(second.render_for(1ms).ok());
    }
    ASSERT_TRUE(second.render_exact().ok());
    ASSERT_TRUE(first.render_exact().ok());
    shared.volume->residency().check_invariants();
    EXPECT_EQ(first.picture().rgba, alone(scene, skin).rgba);
    EXPECT_EQ(second.picture().rgba, alone(scene, dense).rgba);
  }
}

/// How viewers on threads of their own are tried.
struct Trial {
  PoolSizes pools;
  std::uint32_t seed;
  int looks;
  std::uint32_t smaller = 1;  ///< by which pictures are
  std::uint32_t viewers = 8;
};

/// Viewers that come, look, change their minds, and leave.
void expect_pictures_as_alone(const Trial& trial) {
  const TestScene scene = two_viewers_scene();
  const Shared shared(scene, trial.pools);
  std::vector<render::View> views(trial.viewers);
  std::vector<render::Picture> pictures(trial.viewers);
  std::vector<Status> statuses(trial.viewers);
  std::vector<std::thread> threads;
  for (std::uint32_t v = 0; v < trial.viewers; ++v) {
    threads.emplace_back([&, v] {
      std::mt19937 generator(trial.seed + v);
      Viewer viewer(shared.cache);
      for (int look = 0; look < trial.looks && statuses[v].ok(); ++look) {
        views[v] = random_view(scene, generator);
        views[v].width /= trial.smaller;
        views[v].height /= trial.smaller;
        statuses[v] = viewer.look(views[v], shared.volume);
        if (statuses[v].ok() && generator() % 2 == 0) statuses[v] = viewer.render_for(2ms);
      }
      if (statuses[v].ok()) statuses[v] = viewer.render_exact();
      pictures[v] = viewer.picture();
    });
  }
  for (std::thread& thread : threads) thread.join();
  shared.volume->residency().check_invariants();
  for (std::uint32_t v = 0; v < trial.viewers; ++v) {
    ASSERT_TRUE(statuses[v].ok()) << v << ": " << statuses[v].error().message;
    EXPECT_EQ(pictures[v].rgba, alone(scene, views[v]).rgba) << "viewer " << v << ", seed " << trial.seed;
  }
}

TEST(Viewers, eight_at_random_see_what_they_see_alone) {
  expect_pictures_as_alone({{4096, 4000}, 1, 4});
}

TEST(Viewers, eight_at_random_see_what_they_see_alone_where_memory_is_small) {
  expect_pictures_as_alone({{80, 40}, 2, 3});
}

TEST(Viewers, eight_at_random_see_what_they_see_alone_where_memory_is_tiny) {
  expect_pictures_as_alone({{14, 5}, 3, 1, 8});
}

TEST(Viewers, three_at_random_see_what_they_see_alone) {
  expect_pictures_as_alone({{120, 80}, 4, 2, 3, 3});
}

TEST(Viewers, what_one_has_loaded_the_other_need_not) {
  const TestScene scene = two_viewers_scene();
  const Shared shared(scene, std::nullopt);
  Viewer first(shared.cache), second(shared.cache);
  ASSERT_TRUE(first.look(scene.view, shared.volume).ok());
  ASSERT_TRUE(first.render_exact().ok());
  EXPECT_GT(first.statistics().bricks_produced, 20u);
  render::View larger = scene.view;
  larger.background = {1, 1, 1};
  ASSERT_TRUE(second.look(larger, shared.volume).ok());
  ASSERT_TRUE(second.render_exact().ok());
  EXPECT_EQ(second.statistics().bricks_produced, 0u);
  EXPECT_EQ(shared.cache->open(shared.volume->producer()).value(), shared.volume);
}

/// Fails where the left half of the volume is asked for.
class HalfBroken final : public produce::Producer {
 public:
  explicit HalfBroken(std::shared_ptr<const produce::Producer> whole) : whole_(std::move(whole)) {}
  const produce::TreeDescription& description() const override { return whole_->description(); }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    return whole_->describe(keys, infos);
  }
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    if (key.level > 0 && 2 * key.x < (1u << key.level)) return Error{"the left half is broken"};
    return whole_->produce(key, voxels);
  }

 private:
  std::shared_ptr<const produce::Producer> whole_;
};

TEST(Viewers, an_error_is_told_to_the_one_that_it_concerns) {
  const TestScene scene = two_viewers_scene();
  const auto cache = Cache::create(exec::Device::cpu(2), {}).value();
  const auto volume = cache->open(std::make_shared<HalfBroken>(scene.open())).value();
  render::View left = scene.view, right = scene.view;
  left.clip.maximum.x = 0.4;
  // Beside the middle, so that no brick of the left half is blended in.
  right.clip.minimum.x = 0.8;
  right.level_of_detail = left.level_of_detail = false;
  Viewer broken(cache), whole(cache);
  ASSERT_TRUE(broken.look(left, volume).ok());
  ASSERT_TRUE(whole.look(right, volume).ok());
  const Status failed = broken.render_exact();
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(failed.error().message, "the left half is broken");
  EXPECT_TRUE(whole.render_exact().ok());
  EXPECT_FALSE(broken.converged());
}

TEST(Viewers, without_a_view_there_is_an_error_and_an_empty_picture) {
  const TestScene scene = two_viewers_scene();
  const Shared shared(scene, std::nullopt);
  Viewer viewer(shared.cache);
  EXPECT_EQ(viewer.render_exact().error().message, "picture: there is no view yet: call look() first");
  EXPECT_FALSE(viewer.render_for(1ms).ok());
  EXPECT_FALSE(viewer.picture(render::PictureTarget{}).ok());
  EXPECT_TRUE(viewer.picture().rgba.empty());
  EXPECT_FALSE(viewer.converged());
}

}  // namespace
}  // namespace gvx::tests
