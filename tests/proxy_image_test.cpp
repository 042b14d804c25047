// Rays that a proxy cuts make the same pictures, from less.

#include <gtest/gtest.h>

#include "gvx/mesh/mesh_proxy.h"
#include "gvx/produce/field_producer.h"
#include "gvx/produce/hypertexture.h"
#include "gvx/scene/transfer_presets.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

/// A small cloud of 128^3 bytes.
std::shared_ptr<const produce::Producer> cloud() {
  produce::HypertextureOptions options;
  options.thickness = 0.1;
  options.noise = {.octaves = 4, .wavelength = 0.13};
  produce::TreeDescription tree;
  tree.m = 16;
  tree.max_level = 3;
  tree.scale = 1.0 / 255;
  auto balls = std::make_shared<produce::BallsField>(produce::cumulus_balls(4));
  return std::make_shared<produce::FieldProducer>(
      tree, std::make_shared<produce::HypertextureField>(std::move(balls), options));
}

render::View view_of_cloud() {
  render::View view;
  view.width = 90, view.height = 70;
  view.functions = {scene::preset("cloud", {0, 1, {}}).value()};
  view.functions[0].opacities = {{0.2, 0}, {1, 0.1}};
  view.camera = {{0.5, -1, 0.5}, {0.5, 0.5, 0.42}, {0, 0, 1}, 32, 0};
  return view;
}

struct Rendered {
  render::Picture picture;
  engine::Statistics statistics;
};

Rendered exact(const std::shared_ptr<const produce::Producer>& producer, const render::View& view,
               std::shared_ptr<const scene::Proxy> proxy, const exec::Device& device, bool one_ray = false) {
  engine::EngineOptions options;
  options.proxy = std::move(proxy);
  options.one_ray_at_a_time = one_ray;
  const auto engine = engine::Engine::create(device, producer, options).value();
  GVX_CHECK(engine->look(view).ok());
  GVX_CHECK(engine->render_exact().ok());
  return {engine->picture(), engine->statistics()};
}

class ProxyImage : public testing::Test {
 protected:
  void SetUp() override {
    frame_ = render::Frame::make(exec::Device::cpu(1), view_, producer_->description()).value();
    const scene::Visibility visibility = frame_->view().visibility;
    auto proxy = mesh::MeshProxy::around_nodes(*producer_, 3,
                                               [&](const ChannelRanges& r) { return visibility.hides(r); });
    if (!proxy.ok()) GTEST_SKIP() << proxy.error().message;
    proxy_ = std::move(proxy).value();
  }

  std::shared_ptr<const produce::Producer> producer_ = cloud();
  render::View view_ = view_of_cloud();
  std::optional<render::Frame> frame_;
  std::shared_ptr<const scene::Proxy> proxy_;
};

TEST_F(ProxyImage, leaves_every_bit_as_it_is) {
  for (const exec::Device& device : exec::Device::all()) {
    const auto compare = [&](const char* what, auto change) {
      render::View view = view_;
      change(view);
      const Rendered whole = exact(producer_, view, nullptr, device),
                     cut = exact(producer_, view, proxy_, device);
      EXPECT_EQ(cut.picture.rgba, whole.picture.rgba) << what << " on " << device.name();
      EXPECT_LE(cut.statistics.samples, whole.statistics.samples) << what;
      EXPECT_LE(cut.statistics.bricks_produced, whole.statistics.bricks_produced) << what;
      std::printf(
          "%s: %.2f of the samples, %d of %d bricks\n", what,
          double(cut.statistics.samples) / double(std::max<std::uint64_t>(whole.statistics.samples, 1)),
          int(cut.statistics.bricks_produced), int(whole.statistics.bricks_produced));
    };
    compare("from outside", [](auto&) {});
    compare("near", [](auto& v) { v.camera.eye = {0.5, 0.02, 0.45}; });
    compare("from within", [](auto& v) {
      v.camera.eye = {0.5, 0.5, 0.4}, v.camera.target = {0.9, 0.6, 0.5};
    });
    compare("far", [](auto& v) { v.camera.eye = {0.5, -9, 0.5}, v.camera.fov_degrees = 6; });
    compare("very far", [](auto& v) { v.camera.eye = {0.5, -60, 0.5}, v.camera.fov_degrees = 3; });
    compare("orthographic", [](auto& v) { v.camera.height_world = 0.9; });
    compare("finest", [](auto& v) { v.level_of_detail = false; });
    compare("antialiased", [](auto& v) { v.antialias = 2; });
    compare("clipped", [](auto& v) { v.clip = {{0.3, 0.2, 0.1}, {0.7, 0.9, 0.5}}; });
    compare("isosurface", [](auto& v) { v.mode = scene::Mode::isosurface, v.isovalue = 0.6; });
    compare("maximum", [](auto& v) { v.mode = scene::Mode::maximum; });
    compare("post", [](auto& v) { v.classification = scene::Classification::post; });
  }
}

TEST_F(ProxyImage, leaves_one_ray_at_a_time_and_previews_as_they_are) {
  const exec::Device cpu = exec::Device::cpu();
  EXPECT_EQ(exact(producer_, view_, proxy_, cpu, true).picture.rgba,
            exact(producer_, view_, nullptr, cpu, true).picture.rgba);
  engine::EngineOptions options;
  options.proxy = proxy_;
  render::View view = view_;
  for (const auto classification : {scene::Classification::preintegrated, scene::Classification::post}) {
    view.classification = classification;
    const auto engine = engine::Engine::create(cpu, producer_, options).value();
    ASSERT_TRUE(engine->look(view).ok());
    for (int frame = 0; frame < 10000 && !engine->converged(); ++frame) {
      ASSERT_TRUE(engine->render_for(std::chrono::milliseconds(10)).ok());
    }
    EXPECT_EQ(engine->picture().rgba, exact(producer_, view, nullptr, cpu).picture.rgba);
  }
}

TEST_F(ProxyImage, cuts_what_is_not_in_it) {
  // Around the lower half: the upper half is gone, and the lower is as it is.
  io::TriangleMesh box;
  for (int corner = 0; corner < 8; ++corner) {
    box.vertices.push_back({corner & 1 ? 1.2f : -0.2f, corner & 2 ? 1.2f : -0.2f, corner & 4 ? 0.4f : -0.2f});
  }
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const auto half = mesh::MeshProxy::create(box, producer_->description()).value();
  const exec::Device cpu = exec::Device::cpu();
  render::View view = view_;
  view.camera = {{0.5, -3, 0.4}, {0.5, 0.5, 0.4}, {0, 0, 1}, 14, 0};
  const render::Picture whole = exact(producer_, view, nullptr, cpu).picture;
  const render::Picture cut = exact(producer_, view, half, cpu).picture;
  const auto row_differs = [&](std::uint32_t y) {
    for (std::uint32_t i = 0; i < view.width * 4; ++i) {
      if (whole.rgba[y * view.width * 4 + i] != cut.rgba[y * view.width * 4 + i]) return true;
    }
    return false;
  };
  EXPECT_TRUE(row_differs(view.height / 2 - 8));
  EXPECT_FALSE(row_differs(view.height / 2 + 8));
  EXPECT_TRUE(half->inside({0.5, 0.5, 0.3}));
  EXPECT_FALSE(half->inside({0.5, 0.5, 0.5}));
}

}  // namespace
}  // namespace gvx::tests
