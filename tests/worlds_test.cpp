// Worlds of many objects, as viewers render them: instances of shared volumes, budgets, and one memory for
// several volumes.

#include <chrono>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/engine/viewer.h"
#include "object_scenes.h"
#include "test_scenes.h"

namespace gvx::tests {
namespace {

using engine::Cache;
using engine::CacheOptions;
using engine::Object;
using engine::PoolSizes;
using engine::Viewer;
using engine::World;
using namespace std::chrono_literals;

/// Instances of a few volumes: as a world, and as objects of their own for the reference.
struct Instances {
  std::vector<SceneObject> volumes;
  std::vector<std::size_t> volume_of;
  std::vector<Affine3> transforms;
  render::View view;

  std::shared_ptr<const World> world(Cache& cache) const {
    std::vector<Object> objects;
    for (std::size_t i = 0; i < transforms.size(); ++i) {
      const SceneObject& volume = volumes[volume_of[i]];
      objects.push_back({cache.open(volume.producer).value(), transforms[i], volume.view});
    }
    return World::make(std::move(objects)).value();
  }
  ObjectScene scene() const {
    ObjectScene scene;
    scene.view = view;
    for (std::size_t i = 0; i < transforms.size(); ++i) {
      const SceneObject& volume = volumes[volume_of[i]];
      const produce::TreeDescription& tree = volume.producer->description();
      SceneObject placed = object_of(volume.field, transforms[i] * tree.tree_to_world);
      placed.view = volume.view;
      scene.objects.push_back(placed);
    }
    return scene;
  }
};

/// `count` instances of five volumes around the origin, within `spread`, small enough that most stand alone.
Instances random_instances(std::uint32_t seed, std::size_t count, double spread, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-1, 1);
  const auto any = [&] { return Vec3d(share(random), share(random), share(random)); };
  Instances instances;
  for (int i = 0; i < 5; ++i) {
    instances.volumes.push_back(random_object(random, 0));
    instances.volumes.back().view.functions[0].unit_distance *= size;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d x = normalize(any()), z = normalize(cross(x, any()));
    Affine3 place{{size * x, size * cross(z, x), size * (share(random) < 0 ? -1.0 : 1.0) * z}, {}};
    place.column[1] = place.column[1] + 0.3 * share(random) * place.column[0];
    place.origin = spread * any();
    instances.transforms.push_back(place);
    instances.volume_of.push_back(i % instances.volumes.size());
  }
  instances.view.width = 120;
  instances.view.height = 90;
  instances.view.camera = {{0.3, -3.2 * spread, 0.4}, {0, 0, 0}, {0, 0, 1}, 40, 0};
  instances.view.background = {0.1f, 0.2f, 0.3f};
  instances.view.lighting.enabled = false;
  return instances;
}

std::shared_ptr<Cache> cache_of(const CacheOptions& options = {}) {
  return Cache::create(exec::Device::cpu(2), options).value();
}

render::Picture exact(const Instances& instances, const CacheOptions& options = {},
                      engine::Statistics* statistics = nullptr) {
  const auto cache = cache_of(options);
  Viewer viewer(cache);
  const Status looked = viewer.look(instances.view, instances.world(*cache));
  GVX_CHECK(looked.ok());
  const Status rendered = viewer.render_exact();
  EXPECT_TRUE(rendered.ok()) << rendered.error().message;
  if (statistics != nullptr) *statistics = viewer.statistics();
  return viewer.picture();
}

TEST(Worlds, of_one_object_are_what_the_engine_shows) {
  const TestScene scene = analytic_scene("world_of_one", waves, {60, 50, 40}, {1, 1, 1.3}, 2, 8);
  const auto cache = cache_of();
  Viewer viewer(cache);
  const auto world = World::make({{cache->open(scene.open()).value(), {}, scene.view}}).value();
  ASSERT_TRUE(viewer.look(scene.view, world).ok());
  ASSERT_TRUE(viewer.render_exact().ok());
  EXPECT_EQ(viewer.picture().rgba, render_exact(scene).rgba);
}

TEST(Worlds, of_a_thousand_instances_show_what_their_fields_say) {
  const Instances instances = random_instances(4, 1000, 4, 0.8);
  engine::Statistics statistics;
  const render::Picture picture = exact(instances, {}, &statistics);
  EXPECT_LT(statistics.bricks_resident, 5 * 700u) << "instances share their volumes' bricks";
  const double right = psnr(picture, render_reference(instances.scene(), 0.004));
  std::printf("1,000 instances of 5 volumes: %.1f dB to the fields\n", right);
  EXPECT_GE(right, 45);
}

TEST(Worlds, are_the_same_bits_for_every_cache) {
  const Instances instances = random_instances(5, 20, 1.2, 0.8);
  const render::Picture whole = exact(instances);
  CacheOptions tiny;
  tiny.pools = PoolSizes{400, 120};
  EXPECT_EQ(exact(instances, tiny).rgba, whole.rgba);
  // So little memory for all five volumes that each takes from the others.
  CacheOptions little;
  little.memory_bytes = 4 << 20;
  engine::Statistics statistics;
  EXPECT_EQ(exact(instances, little, &statistics).rgba, whole.rgba);
  EXPECT_GT(statistics.bricks_evicted + statistics.bricks_produced, 0u);
}

TEST(Worlds, rendered_within_budgets_come_to_the_exact_picture) {
  const Instances instances = random_instances(6, 20, 1.2, 0.8);
  const auto cache = cache_of();
  Viewer viewer(cache);
  ASSERT_TRUE(viewer.look(instances.view, instances.world(*cache)).ok());
  double first = 0;
  const render::Picture whole = exact(instances);
  for (int frame = 0; frame < 5000 && !viewer.converged(); ++frame) {
    ASSERT_TRUE(viewer.render_for(5ms).ok());
    if (frame == 0) first = psnr(viewer.picture(), whole);
  }
  EXPECT_TRUE(viewer.converged());
  EXPECT_GT(first, 12) << "a first frame shows something";
  EXPECT_EQ(psnr(viewer.picture(), whole), INFINITY);
  EXPECT_EQ(viewer.picture().rgba, whole.rgba);
}

TEST(Worlds, cost_what_is_seen_of_them) {
  Instances few = random_instances(7, 10, 0.8, 0.8);
  Instances many = few;
  // Behind the camera.
  std::mt19937 random(8);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 5000; ++i) {
    Affine3 place = few.transforms[static_cast<std::size_t>(i) % 10];
    place.origin = {20 * share(random) - 10, -8 - 20 * share(random), 20 * share(random) - 10};
    many.transforms.push_back(place);
    many.volume_of.push_back(static_cast<std::size_t>(i) % 5);
  }
  engine::Statistics of_few, of_many;
  EXPECT_EQ(exact(few, {}, &of_few).rgba, exact(many, {}, &of_many).rgba);
  EXPECT_EQ(of_few.bricks_produced, of_many.bricks_produced);
  EXPECT_EQ(of_few.samples, of_many.samples);
}

TEST(Worlds, what_is_wrong_with_an_object_is_told_with_its_number) {
  const auto cache = cache_of();
  const auto volume = cache->open(random_instances(1, 1, 1, 1).volumes[0].producer).value();
  EXPECT_EQ(World::make({}).error().message, "objects: there are none");
  EXPECT_EQ(World::make({{volume, {}, {}}, {nullptr, {}, {}}}).error().message, "objects[1]: no volume");
  EXPECT_EQ(World::make({{volume, scaling({1, 0, 1}), {}}}).error().message,
            "objects[0].transform: it has no usable inverse");
  const auto world = World::make({{volume, {}, {}}, {volume, {}, {}}}).value();
  Viewer viewer(cache);
  EXPECT_EQ(viewer.look(random_instances(1, 1, 1, 1).view, world).error().message,
            "objects[0]: transfer function: none given");
  EXPECT_EQ(cache->open(nullptr).error().message, "volume: no producer");
}

}  // namespace
}  // namespace gvx::tests
