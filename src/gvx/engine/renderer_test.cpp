#include "gvx/engine/renderer.h"

#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/produce/field_producer.h"

namespace gvx::engine {
namespace {

using namespace std::chrono_literals;

/// A ball whose bricks take a while, or cannot be made.
class SlowBall final : public produce::Producer {
 public:
  SlowBall(std::chrono::milliseconds time, bool broken) : time_(time), broken_(broken) {
    produce::TreeDescription tree;
    tree.m = 8;
    tree.max_level = 3;
    field_ = std::make_shared<produce::FieldProducer>(
        tree, [](Vec3d p) { return static_cast<float>(0.4 - length(p - Vec3d(0.5))); },
        [](const Box3d& b) {
          const double middle = 0.4 - length(0.5 * (b.minimum + b.maximum) - Vec3d(0.5));
          const double reach = 0.51 * length(b.maximum - b.minimum);
          return ValueRange{static_cast<float>(middle - reach), static_cast<float>(middle + reach)};
        });
  }
  const produce::TreeDescription& description() const override { return field_->description(); }
  Status describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const override {
    return field_->describe(keys, infos);
  }
  Status produce(const NodeKey& key, std::span<std::byte> voxels) const override {
    std::this_thread::sleep_for(time_);
    if (broken_ && key.level == 3) return Error{"no finest bricks"};
    return field_->produce(key, voxels);
  }

 private:
  std::chrono::milliseconds time_;
  bool broken_;
  std::shared_ptr<const produce::Producer> field_;
};

struct Scene {
  std::shared_ptr<Cache> cache = Cache::create(exec::Device::cpu(2), {}).value();
  std::shared_ptr<Volume> volume;
  render::View view;

  explicit Scene(std::chrono::milliseconds time, bool broken = false)
      : volume(cache->open(std::make_shared<SlowBall>(time, broken)).value()) {
    view.width = 64;
    view.height = 48;
    view.camera = {{0.5, -1.5, 0.6}, {0.5, 0.5, 0.5}, {0, 0, 1}, 30, 0};
    view.functions = {{{{0, {1, 0.5, 0.2}}}, {{0, 0}, {0.1, 1}}, 0.1, {}}};
    view.level_of_detail = false;
  }
};

TEST(Renderer, renders_beside_its_caller_what_the_caller_would) {
  Scene scene(0ms);
  Viewer here(scene.cache), there(scene.cache), late(scene.cache);
  for (Viewer* viewer : {&here, &there, &late}) ASSERT_TRUE(viewer->look(scene.view, scene.volume).ok());
  ASSERT_TRUE(here.render_exact().ok());
  Renderer renderer;
  int reports = 0;
  FrameRequest request;
  request.on_progress = [&](const Viewer& viewer) { reports += viewer.picture().width == 64 ? 1 : 0; };
  const Renderer::Frame first = renderer.start(there, request), second = renderer.start(late, {});
  EXPECT_TRUE(first.wait().ok());
  EXPECT_TRUE(second.wait().ok());
  EXPECT_TRUE(first.done() && second.done());
  EXPECT_GT(reports, 0);
  EXPECT_TRUE(there.converged() && late.converged());
  EXPECT_EQ(there.picture().rgba, here.picture().rgba);
  EXPECT_EQ(late.picture().rgba, here.picture().rgba);
}

TEST(Renderer, a_budget_ends_a_frame_and_cancelling_too) {
  Scene scene(30ms);
  Viewer viewer(scene.cache);
  ASSERT_TRUE(viewer.look(scene.view, scene.volume).ok());
  Renderer renderer;
  FrameRequest request;
  request.budget = 50ms;
  EXPECT_TRUE(renderer.start(viewer, request).wait().ok());
  EXPECT_FALSE(viewer.converged());
  Renderer::Frame endless = renderer.start(viewer, {});
  EXPECT_FALSE(endless.wait_for(1ms).has_value());
  endless.cancel();
  EXPECT_EQ(endless.wait().error().message, "cancelled");
  // A new renderer goes on where that one stopped.
  Renderer again;
  EXPECT_TRUE(again.start(viewer, {}).wait().ok());
  EXPECT_TRUE(viewer.converged());
}

TEST(Renderer, errors_reach_who_waits) {
  Scene scene(0ms, true);
  Viewer viewer(scene.cache), blind(scene.cache);
  ASSERT_TRUE(viewer.look(scene.view, scene.volume).ok());
  Renderer renderer;
  EXPECT_EQ(renderer.start(viewer, {}).wait().error().message, "no finest bricks");
  EXPECT_EQ(renderer.start(blind, {}).wait().error().message,
            "picture: there is no view yet: call look() first");
}

TEST(Renderer, shares_a_frame_out_among_viewers) {
  Scene scene(1ms);
  Viewer first(scene.cache), second(scene.cache);
  Viewer* const viewers[] = {&first, &second};
  render::View other = scene.view;
  other.camera.eye.x = 1.5;
  ASSERT_TRUE(first.look(scene.view, scene.volume).ok());
  ASSERT_TRUE(second.look(other, scene.volume).ok());
  for (int frame = 0; frame < 2000 && !(first.converged() && second.converged()); ++frame) {
    ASSERT_TRUE(Renderer::frame(viewers, 20ms).ok());
  }
  EXPECT_TRUE(first.converged() && second.converged());
  Viewer* const none[] = {&first, nullptr};
  EXPECT_EQ(Renderer::frame(none, 1ms).error().message, "viewers[1]: none");
}

}  // namespace
}  // namespace gvx::engine
