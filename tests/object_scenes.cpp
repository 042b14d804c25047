#include "object_scenes.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "gvx/exec/parallel.h"
#include "gvx/produce/examine_element.h"
#include "gvx/produce/field_producer.h"

namespace gvx::tests {
namespace {

Affine3 turned(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto any = [&] { return Vec3d(normal(random), normal(random), normal(random)); };
  const Vec3d x = normalize(any()), z = normalize(cross(x, any()));
  return {{x, cross(z, x), z}, {}};
}

std::uint32_t projecting(const ObjectScene& scene) {
  const auto projects = [](const SceneObject& object) { return scene::projects(object.view.mode); };
  return static_cast<std::uint32_t>(std::count_if(scene.objects.begin(), scene.objects.end(), projects));
}

/// The film's rays that are not finished.
std::uint64_t unfinished(const render::Film& film) {
  return film.totals().unfinished;
}

}  // namespace

render::View ObjectScene::view_of(const SceneObject& object) const {
  render::View of = object.view;
  of.width = view.width;
  of.height = view.height;
  of.camera = view.camera;
  of.background = view.background;
  of.level_of_detail = view.level_of_detail;
  return of;
}

SceneObject object_of(const AnalyticField& field, const Affine3& tree_to_world, const TreeWanted& wanted) {
  produce::TreeDescription tree;
  tree.n = wanted.n;
  tree.m = wanted.m;
  tree.max_level = wanted.max_level;
  tree.format.type = wanted.type;
  tree.scale = wanted.type == VoxelType::u8 ? 1.0 / 255 : wanted.type == VoxelType::u16 ? 1.0 / 65535 : 1;
  tree.tree_to_world = tree_to_world;
  const auto value = [field](Vec3d p) { return static_cast<float>(field.value(p)); };
  const auto bounds = [field](const Box3d& box) {
    const double middle = field.value(0.5 * (box.minimum + box.maximum));
    const double reach = 0.5 * field.steepest * length(box.maximum - box.minimum);
    return ValueRange{static_cast<float>(std::max(middle - reach, 0.0)),
                      static_cast<float>(std::min(middle + reach, 1.0))};
  };
  SceneObject object;
  object.field = field;
  object.producer =
      std::make_shared<produce::FieldProducer>(tree, std::make_shared<produce::FunctionField>(value, bounds));
  object.view.functions = {{{{0, {1, 0.5, 0.2}}}, {{0.3, 0}, {1, 0.6}}, 0.1}};
  object.view.lighting.enabled = false;
  return object;
}

AnalyticField soft_ball(Vec3d centre, double narrow) {
  return {[=](Vec3d p) { return std::exp(-narrow * dot(p - centre, p - centre)); },
          std::sqrt(2 * narrow / std::exp(1.0))};
}

AnalyticField waves_along(Vec3d wave) {
  return {[=](Vec3d p) { return 0.5 + 0.5 * std::sin(dot(wave, p)); }, 0.5 * length(wave)};
}

SceneObject random_object(std::mt19937& random, double spread) {
  std::uniform_real_distribution<double> share(0, 1);
  const auto between = [&](double a, double b) { return a + (b - a) * share(random); };
  const auto any = [&](double most) {
    return Vec3d(between(-most, most), between(-most, most), between(-most, most));
  };
  const Vec3d sizes(between(0.5, 1.2), between(0.5, 1.2), between(0.5, 1.2));
  Affine3 sheared = scaling(sizes * Vec3d(share(random) < 0.3 ? -1 : 1, 1, 1));
  sheared.column[1] = sheared.column[1] + between(-0.3, 0.3) * sheared.column[0];
  Affine3 place = turned(random) * sheared;
  place.origin = any(spread) - place.vector(Vec3d(0.5));
  constexpr TreeWanted kTrees[] = {{VoxelType::u8, 2, 8, 3},
                                   {VoxelType::u16, 3, 8, 2},
                                   {VoxelType::f32, 2, 16, 2},
                                   {VoxelType::f32, 2, 32, 1}};
  const TreeWanted& tree = kTrees[std::min<std::size_t>(3, std::size_t(4 * share(random)))];
  const AnalyticField field =
      share(random) < 0.5 ? soft_ball(Vec3d(0.5) + any(0.2), between(6, 14)) : waves_along(any(9));
  SceneObject object = object_of(field, place, tree);
  const auto color = [&] { return Vec3d(share(random), share(random), share(random)); };
  const double first = between(0.1, 0.5);
  object.view.functions = {
      {{{0, color()}, {1, color()}}, {{first, 0}, {between(0.7, 1), between(0.1, 0.7)}}, between(0.05, 0.3)}};
  return object;
}

ObjectScene random_scene(std::uint32_t seed, int objects, double spread) {
  std::mt19937 random(seed);
  ObjectScene scene;
  for (int i = 0; i < objects; ++i) scene.objects.push_back(random_object(random, spread));
  scene.view.width = 120;
  scene.view.height = 90;
  scene.view.camera.eye = (2.0 + 1.5 * spread) * normalize(turned(random).column[0]);
  scene.view.camera.target = {};
  scene.view.camera.up = turned(random).column[1];
  scene.view.camera.fov_degrees = 40;
  scene.view.background = {0.1f, 0.2f, 0.3f};
  return scene;
}

ResidentScene::Resident::Resident(const exec::Device& device, const SceneObject& object,
                                  const render::View& view, engine::PoolSizes pools)
    : producer(*object.producer),
      frame(render::Frame::make(device, view, producer.description()).value()),
      residency(device, producer, produce::TreeId(1), pools),
      look(device, pools.tiles, pools.bricks) {
  residency.attach(look);
  GVX_CHECK(residency.plant_root().ok());
  residency.commit({made(*residency.ask_for_root())}, engine::Eviction::any);
  residency.set_visibility(look, frame.view().visibility);
}

produce::FinishedElement ResidentScene::Resident::made(const produce::ElementKey& key) const {
  return {key, produce::make_element(producer, key.node, key.kind)};
}

render::ObjectView ResidentScene::Resident::view() {
  const produce::TreeDescription& tree = producer.description();
  return {.n = tree.n,
          .m = tree.m,
          .frame = frame.view(),
          .nodes = residency.nodes().view(),
          .hidden = look.hidden(),
          .bricks = residency.bricks().bytes(),
          .tile_usage = residency.tile_usage(),
          .brick_usage = residency.brick_usage(),
          .requests = residency.requests(),
          .cells = look.cells()};
}

ResidentScene::ResidentScene(const ObjectScene& scene, const HowRendered& how)
    : scene_(scene),
      how_(how),
      random_(how.seed),
      film_(how.device, scene.view.width, scene.view.height, projecting(scene)) {
  for (const SceneObject& object : scene.objects) {
    residents_.push_back(std::make_unique<Resident>(how.device, object, scene.view_of(object), how.pools));
  }
}

render::Pass ResidentScene::next_pass() {
  ++number_;
  views_.clear();
  for (const auto& resident : residents_) views_.push_back(resident->view());
  render::Pass pass;
  pass.film = render::film_of(scene_.view).value();
  pass.objects = views_;
  pass.number = number_;
  pass.epoch = film_.epoch();
  pass.blank_tiles = film_.blank_tiles();
  pass.projections = film_.projections();
  pass.one_ray_at_a_time = how_.one_ray_at_a_time;
  return pass;
}

render::Bundle ResidentScene::bundle_at(Vec3d origin, ConeShape cones) const {
  const Resident& first = *residents_[0];
  return first.frame.bundle_at(how_.device, first.producer.description(), Vec3dd(origin), cones);
}

render::RayState ResidentScene::march_ray(const render::Bundle& bundle, const render::BundleRay& ray) {
  render::RayState state;
  constexpr int kMostPasses = 300;
  for (int i = 0; i < kMostPasses && state.phase == render::RayPhase::under_way; ++i) {
    const render::Pass pass = next_pass();
    views_[0].frame = residents_[0]->frame.view_from(bundle);
    render::march_ray(pass, views_[0], ray, state);
    if (state.phase == render::RayPhase::under_way) produce_lacking();
  }
  EXPECT_EQ(state.phase, render::RayPhase::finished);
  return state;
}

void ResidentScene::produce_lacking() {
  std::uniform_real_distribution<double> share(0, 1);
  for (const auto& resident : residents_) {
    const std::vector<engine::Lacking> all = resident->residency.collect(number_, number_);
    engine::Room room = resident->residency.room(engine::Eviction::unused);
    std::vector<produce::FinishedElement> made;
    for (const engine::Lacking& lacking : all) {
      if (share(random_) < how_.withheld || !room.take(lacking.element.kind)) continue;
      made.push_back(resident->made(lacking.element));
    }
    resident->residency.commit(std::move(made), engine::Eviction::unused);
  }
}

render::Picture ResidentScene::render_exact() {
  const exec::TileGrid grid = film_.grid();
  exec::Buffer<std::uint32_t> tiles(how_.device, grid.tiles()), flags(how_.device, grid.tiles());
  for (std::uint32_t t = 0; t < grid.tiles(); ++t) tiles.view()[t] = t;
  constexpr std::uint32_t kMostPasses = 3000;
  do {
    const render::Pass pass = next_pass();
    std::fill_n(flags.view().begin(), grid.tiles(), 0u);
    const render::TilesMarch march{pass, grid, tiles.view(), exec::no_deadline()};
    render::march_exact(how_.device, {march, film_.rays(), flags.view()});
    produce_lacking();
  } while (unfinished(film_) > 0 && number_ < kMostPasses);
  EXPECT_EQ(unfinished(film_), 0u);
  return film_.develop(how_.device, {1, scene_.view.background, true});
}

namespace {

/// What a ray of the reference sees of an object.
struct ReferenceObject {
  const SceneObject& object;
  Ray tree;  // t is the distance in the world
  RayInterval inside;

  double value(double t) const { return object.field.value(tree.at(t)); }
  const scene::TransferFunction& function() const { return object.view.functions[0]; }
};

/// A sample that is all there is of an object: a surface, or what a projection shows.
struct LoneSample {
  double t;
  Vec3d color;
  double opacity;
};

struct ReferenceRay {
  std::vector<ReferenceObject> objects;
  double step;
  std::vector<LoneSample> samples = {};
  Vec3d color = {};
  double left = 1;

  void add(Vec3d c, double opacity) {
    color = color + left * opacity * c;
    left *= 1 - opacity;
  }

  void find_surface(const ReferenceObject& o) {
    const double isovalue = o.object.view.isovalue;
    for (double t = o.inside.enter; t + step < o.inside.exit; t += step) {
      if ((o.value(t) < isovalue) == (o.value(t + step) < isovalue)) continue;
      return samples.push_back({t + 0.5 * step, o.function().color(isovalue), 1});
    }
  }
  void project(const ReferenceObject& o) {
    const scene::Mode mode = o.object.view.mode;
    double all = 0, at = 0.5 * (o.inside.enter + o.inside.exit), count = 0;
    for (double t = o.inside.enter + 0.5 * step; t < o.inside.exit; t += step, ++count) {
      const double value = o.value(t);
      const bool better = count == 0 || (mode == scene::Mode::maximum ? value > all : value < all);
      if (mode == scene::Mode::mean) {
        all += value;
      } else if (better) {
        all = value, at = t;
      }
    }
    if (mode == scene::Mode::mean) all /= count;
    if (count > 0) samples.push_back({at, o.function().color(all), o.function().opacity(all)});
  }

  void march() {
    double begin = INFINITY, end = 0;
    for (const ReferenceObject& o : objects) {
      begin = std::min(begin, o.inside.enter);
      end = std::max(end, o.inside.exit);
      const scene::Mode mode = o.object.view.mode;
      if (mode == scene::Mode::composite) continue;
      mode == scene::Mode::isosurface ? find_surface(o) : project(o);
    }
    std::sort(samples.begin(), samples.end(), [](auto& a, auto& b) { return a.t < b.t; });
    std::size_t next = 0;
    for (double t = begin + 0.5 * step; t < end && left > 1e-4; t += step) {
      double extinction = 0;
      Vec3d sum;
      for (const ReferenceObject& o : objects) {
        if (o.object.view.mode != scene::Mode::composite || t < o.inside.enter || t > o.inside.exit) continue;
        const double value = o.value(t);
        const double e = -std::log1p(-o.function().opacity(value)) / o.function().unit_distance;
        sum = sum + e * o.function().color(value);
        extinction += e;
      }
      if (extinction > 0) add(sum / extinction, 1 - std::exp(-extinction * step));
      for (; next < samples.size() && samples[next].t < t + 0.5 * step; ++next) {
        add(samples[next].color, samples[next].opacity);
      }
    }
  }
};

}  // namespace

render::Picture render_reference(const ObjectScene& scene, double step_world) {
  const render::View& view = scene.view;
  const scene::CameraView camera = scene::make_view(view.camera, view.width, view.height).value();
  render::Picture picture{view.width, view.height,
                          std::vector<float>(std::size_t(view.width) * view.height * 4, 1.0f)};
  exec::parallel_for(exec::Device::cpu(), view.height, [&](std::size_t y) {
    for (std::uint32_t x = 0; x < view.width; ++x) {
      const Ray world = camera.pixel_ray(x, double(y));
      ReferenceRay ray{{}, step_world};
      for (const SceneObject& object : scene.objects) {
        const Affine3 to_tree = inverse(object.producer->description().tree_to_world);
        const Ray tree{to_tree.point(world.origin), to_tree.vector(world.direction)};
        const RayInterval inside = intersect(tree, object.view.clip, 0, 1e300);
        if (!inside.empty()) ray.objects.push_back({object, tree, inside});
      }
      ray.march();
      float* const out = &picture.rgba[4 * (y * view.width + x)];
      for (int c = 0; c < 3; ++c) {
        out[c] = static_cast<float>(std::min(1.0, ray.color[c]) + ray.left * double(view.background[c]));
      }
    }
  });
  return picture;
}

}  // namespace gvx::tests
