// Surfaces in a world, as viewers render them: out of core, within a budget, and in one picture with volumes.

#include <chrono>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/engine/viewer.h"
#include "gvx/mesh/mesh_test_support.h"
#include "gvx/mesh/surface_store.h"
#include "gvx/surface/stored_surface.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

using engine::Cache;
using engine::CacheOptions;
using engine::Object;
using engine::Viewer;
using engine::World;
using namespace std::chrono_literals;

std::shared_ptr<const produce::Producer> open_surface(const std::string& name, const io::TriangleMesh& mesh) {
  const std::string path = testing::TempDir() + name + ".gvx";
  const auto spool = mesh::spooled(mesh);
  GVX_CHECK(mesh::build_surface_store(*spool, path, {}).ok());
  return surface::StoredSurface::open(path).value();
}

/// A ball with colours.
io::TriangleMesh colored_ball(Vec3d centre, double radius, int cuts) {
  io::TriangleMesh mesh = mesh::sphere_mesh(centre, radius, cuts);
  for (const Vec3f& v : mesh.vertices) mesh.colors.emplace_back(0.5f + 0.4f * std::sin(9 * v.x), 0.6f, 0.3f);
  return mesh;
}

render::View view_of_middle(std::uint32_t width, std::uint32_t height) {
  render::View view;
  view.width = width;
  view.height = height;
  view.camera = {{0.5, -2.6, 0.9}, {0.5, 0.5, 0.5}, {0, 0, 1}, 30, 0};
  view.background = {0.1f, 0.2f, 0.3f};
  return view;
}

struct Rendered {
  render::Picture picture;
  engine::Statistics statistics;
};

Rendered exact_picture(const std::shared_ptr<const produce::Producer>& surface, const render::View& view,
                       std::uint64_t memory, int threads) {
  CacheOptions options;
  options.memory_bytes = memory;
  const auto cache = Cache::create(exec::Device::cpu(threads), options).value();
  Viewer viewer(cache);
  const auto world = World::make({{nullptr, {}, {}, cache->open_surface(surface).value()}}).value();
  EXPECT_TRUE(viewer.look(view, world).ok());
  const Status done = viewer.render_exact();
  EXPECT_TRUE(done.ok()) << done.error().message;
  EXPECT_TRUE(viewer.converged());
  return {viewer.picture(), viewer.statistics()};
}

TEST(Surfaces, exact_pictures_are_the_same_bits_for_any_memory_and_threads) {
  const auto surface = open_surface("surfaces_bits", colored_ball({0.5, 0.5, 0.5}, 0.4, 7));
  render::View view = view_of_middle(320, 240);
  view.antialias = 2;
  const Rendered all = exact_picture(surface, view, 64 << 20, 1);
  EXPECT_EQ(all.statistics.bricks_evicted, 0u);
  for (const std::uint64_t memory : {1u << 20, 200u << 10, 60u << 10}) {
    const Rendered little = exact_picture(surface, view, memory, 2);
    EXPECT_EQ(all.picture.rgba, little.picture.rgba) << memory;
    EXPECT_LE(little.statistics.bricks_resident * 256, memory);
  }
}

TEST(Surfaces, memory_that_holds_no_brick_is_an_error) {
  const auto surface = open_surface("surfaces_none", colored_ball({0.5, 0.5, 0.5}, 0.4, 6));
  CacheOptions options;
  options.memory_bytes = 2000;
  const auto cache = Cache::create(exec::Device::cpu(1), options).value();
  Viewer viewer(cache);
  const auto world = World::make({{nullptr, {}, {}, cache->open_surface(surface).value()}}).value();
  ASSERT_TRUE(viewer.look(view_of_middle(64, 64), world).ok());
  const Status done = viewer.render_exact();
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().message.rfind("memory: ", 0), 0u) << done.error().message;
}

TEST(Surfaces, frames_of_a_budget_become_the_exact_picture) {
  const auto surface = open_surface("surfaces_budget", colored_ball({0.5, 0.5, 0.5}, 0.4, 7));
  const render::View view = view_of_middle(320, 240);
  const Rendered exact = exact_picture(surface, view, 64 << 20, 2);
  const auto cache = Cache::create(exec::Device::cpu(2), {}).value();
  Viewer viewer(cache);
  const auto world = World::make({{nullptr, {}, {}, cache->open_surface(surface).value()}}).value();
  ASSERT_TRUE(viewer.look(view, world).ok());
  int frames = 0;
  for (; !viewer.converged() && frames < 1000; ++frames) {
    ASSERT_TRUE(viewer.render_for(1ms).ok());
    if (frames > 0) continue;
    // The ball is there from the first frame on, if roughly.
    const render::Picture first = viewer.picture();
    const std::size_t middle = 4 * (120u * 320 + 160);
    EXPECT_NE(first.rgba[middle], view.background.x);
  }
  ASSERT_TRUE(viewer.converged());
  EXPECT_EQ(viewer.picture().rgba, exact.picture.rgba);
}

/// Fog of one colour and density in the unit cube, in which a ball stands: what a ray sees of it is known.
class Fog : public testing::Test {
 protected:
  static constexpr float kOpacity = 0.3f;
  static constexpr double kUnit = 0.25;
  const Vec3d centre_{0.45, 0.4, 0.55};
  const double radius_ = 0.23;

  void SetUp() override {
    const TestScene scene = analytic_scene(
        "surfaces_fog", [](Vec3d) { return 0.5; }, {24, 24, 24}, Vec3d(1.0 / 24), 2, 8);
    fog_ = scene.open();
    mesh_ = mesh::sphere_mesh(centre_, radius_, 6);
    mesh_.colors.assign(mesh_.vertices.size(), {0.8f, 0.4f, 0.2f});
    ball_ = open_surface("surfaces_ball", mesh_);
    view_ = view_of_middle(160, 120);
    view_.lighting.enabled = false;
    view_.functions = {{{{0, {0.2f, 0.5f, 0.9f}}}, {{0, kOpacity}}, kUnit}};
  }

  std::shared_ptr<const World> world(Cache& cache) const {
    return World::make(
               {{cache.open(fog_).value(), {}, view_}, {nullptr, {}, {}, cache.open_surface(ball_).value()}})
        .value();
  }

  /// What the ray of a pixel's middle sees; nothing where it comes near the ball's silhouette.
  std::optional<Vec3f> expected(std::uint32_t x, std::uint32_t y, double* depth = nullptr) const {
    const auto camera = scene::make_view(view_.camera, view_.width, view_.height).value();
    const Ray ray = camera.pixel_ray(x, y);
    const RayInterval inside = intersect(ray, {{0, 0, 0}, {1, 1, 1}}, 0, 1e9);
    const Vec3d to_centre = centre_ - ray.origin;
    const double along = dot(to_centre, ray.direction), aside = length(to_centre - along * ray.direction);
    const double edge = 3 * camera.pixel * along;
    if (std::fabs(aside - radius_) < edge) return std::nullopt;
    const bool hits = aside < radius_;
    const double at = along - std::sqrt(std::max(radius_ * radius_ - aside * aside, 0.0));
    const double way =
        inside.empty() ? 0 : std::max((hits ? std::min(at, inside.exit) : inside.exit) - inside.enter, 0.0);
    const auto through = static_cast<float>(std::pow(1 - kOpacity, way / kUnit));
    const Vec3f behind = hits ? Vec3f(0.8f, 0.4f, 0.2f) : view_.background;
    if (depth != nullptr) *depth = hits ? at * dot(ray.direction, camera.forward) : INFINITY;
    return (1 - through) * Vec3f(0.2f, 0.5f, 0.9f) + through * behind;
  }

  void expect_right(const render::Picture& picture) const {
    int compared = 0;
    float worst = 0;
    for (std::uint32_t y = 0; y < view_.height; ++y) {
      for (std::uint32_t x = 0; x < view_.width; ++x) {
        const auto right = expected(x, y);
        if (!right) continue;
        ++compared;
        const float* rgba = &picture.rgba[4 * (std::size_t(y) * view_.width + x)];
        for (int c = 0; c < 3; ++c) worst = std::max(worst, std::fabs(rgba[c] - (*right)[c]));
      }
    }
    EXPECT_GT(compared, int(view_.width * view_.height * 9 / 10));
    // A cell of the surface is 1/200 of the fog's way, and shows that much less or more of it.
    EXPECT_LT(worst, 0.012f);
  }

  std::shared_ptr<const produce::Producer> fog_, ball_;
  io::TriangleMesh mesh_;
  render::View view_;
};

TEST_F(Fog, ends_where_a_surface_is_at_every_pixel) {
  const auto cache = Cache::create(exec::Device::cpu(2), {}).value();
  Viewer viewer(cache);
  ASSERT_TRUE(viewer.look(view_, world(*cache)).ok());
  ASSERT_TRUE(viewer.render_exact().ok());
  expect_right(viewer.picture());
}

TEST_F(Fog, with_a_surface_is_the_same_bits_one_ray_at_a_time_or_with_little_memory_within_rounding) {
  const auto cache = Cache::create(exec::Device::cpu(1), {}).value();
  Viewer viewer(cache);
  ASSERT_TRUE(viewer.look(view_, world(*cache)).ok());
  ASSERT_TRUE(viewer.render_exact().ok());
  CacheOptions little;
  little.memory_bytes = 400 << 10;
  const auto small = Cache::create(exec::Device::cpu(2), little).value();
  Viewer other(small);
  ASSERT_TRUE(other.look(view_, world(*small)).ok());
  ASSERT_TRUE(other.render_exact().ok());
  EXPECT_EQ(viewer.picture().rgba, other.picture().rgba);
}

TEST_F(Fog, and_a_surface_converge_within_a_budget) {
  const auto cache = Cache::create(exec::Device::cpu(2), {}).value();
  Viewer viewer(cache);
  ASSERT_TRUE(viewer.look(view_, world(*cache)).ok());
  for (int frame = 0; frame < 2000 && !viewer.converged(); ++frame) ASSERT_TRUE(viewer.render_for(2ms).ok());
  ASSERT_TRUE(viewer.converged());
  expect_right(viewer.picture());
  Viewer exact(cache);
  ASSERT_TRUE(exact.look(view_, world(*cache)).ok());
  ASSERT_TRUE(exact.render_exact().ok());
  EXPECT_EQ(viewer.picture().rgba, exact.picture().rgba);
}

TEST_F(Fog, tells_depth_and_object_of_what_is_seen) {
  // So thin that the ball alone hides half of what is behind it.
  view_.functions = {{{{0, {0.2f, 0.5f, 0.9f}}}, {{0, 0.02f}}, kUnit}};
  const auto cache = Cache::create(exec::Device::cpu(2), {}).value();
  Viewer viewer(cache);
  ASSERT_TRUE(viewer.look(view_, world(*cache)).ok());
  ASSERT_TRUE(viewer.render_exact().ok());
  std::vector<float> depth(std::size_t(view_.width) * view_.height);
  std::vector<std::int32_t> object(depth.size());
  ASSERT_TRUE(viewer.picture({.depth = {depth}, .object = {object}}).ok());
  int on_ball = 0;
  for (std::uint32_t y = 0; y < view_.height; ++y) {
    for (std::uint32_t x = 0; x < view_.width; ++x) {
      double right = INFINITY;
      if (!expected(x, y, &right)) continue;
      const std::size_t at = std::size_t(y) * view_.width + x;
      EXPECT_EQ(object[at], right < INFINITY ? 1 : -1);
      if (!(right < INFINITY)) continue;
      ++on_ball;
      EXPECT_NEAR(depth[at], right, 0.02) << "a pixel is 0.013 wide";
    }
  }
  EXPECT_GT(on_ball, 500);
}

TEST_F(Fog, of_two_viewers_each_sees_its_own) {
  const auto cache = Cache::create(exec::Device::cpu(2), {}).value();
  Viewer first(cache), second(cache);
  ASSERT_TRUE(first.look(view_, world(*cache)).ok());
  render::View from_above = view_;
  from_above.camera = {{0.5, 0.4, 3}, {0.5, 0.5, 0.5}, {0, 1, 0}, 30, 0};
  ASSERT_TRUE(second.look(from_above, world(*cache)).ok());
  ASSERT_TRUE(second.render_exact().ok());
  ASSERT_TRUE(first.render_exact().ok());
  expect_right(first.picture());
}

}  // namespace
}  // namespace gvx::tests
