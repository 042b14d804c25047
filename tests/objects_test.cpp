// Scenes of several objects: what overlaps is seen together, in order along each ray.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/engine/cache.h"
#include "gvx/engine/viewer.h"
#include "gvx/engine/world.h"
#include "gvx/render/reference/object_ray.h"
#include "gvx/render/tile/object_tiles.h"
#include "object_scenes.h"

namespace gvx::tests {
namespace {

/// Tiles of rays and rays one by one show the same, and both what the fields say.
void expect_right(const ObjectScene& scene, const std::string& what, double least_decibels) {
  HowRendered one_by_one;
  one_by_one.one_ray_at_a_time = true;
  const render::Picture picture = ResidentScene(scene, {}).render_exact();
  const render::Picture plain = ResidentScene(scene, one_by_one).render_exact();
  const render::Picture reference = render_reference(scene, 0.003);
  const double alike = psnr(picture, plain), right = psnr(picture, reference);
  std::printf("%-40s %6.1f dB to one ray at a time, %5.1f dB to the fields\n", what.c_str(), alike, right);
  EXPECT_GE(alike, 60) << what;
  EXPECT_GE(right, least_decibels) << what;
}

/// Objects in a row along x, each within half a unit of its place, seen from the front.
ObjectScene row_of(const std::vector<scene::Mode>& modes, double apart) {
  ObjectScene scene;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    Affine3 place;
    place.origin = {apart * (double(i) - 0.5 * double(modes.size() - 1)) - 0.5, -0.5, -0.5};
    scene.objects.push_back(object_of(soft_ball(Vec3d(0.5), 12), place));
    scene.objects.back().view.mode = modes[i];
    scene.objects.back().view.isovalue = 0.6;
  }
  scene.view.width = 150;
  scene.view.height = 80;
  scene.view.camera = {{0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 30};
  scene.view.background = {0.1f, 0.2f, 0.3f};
  return scene;
}

TEST(Objects, that_are_composited_show_what_their_fields_say) {
  for (const std::uint32_t seed : {1u, 2u}) {
    for (const int objects : {2, 5, 30}) {
      const std::string what = std::to_string(objects) + " objects, seed " + std::to_string(seed);
      expect_right(random_scene(seed, objects, objects > 5 ? 2.0 : 0.5), what, 55);
    }
  }
}

TEST(Objects, of_every_mode_are_seen_where_they_lie) {
  for (const scene::Mode mode :
       {scene::Mode::isosurface, scene::Mode::maximum, scene::Mode::minimum, scene::Mode::mean}) {
    ObjectScene scene = random_scene(7, 4, 0.5);
    for (const std::size_t i : {0, 2}) {
      scene.objects[i].view.mode = mode;
      scene.objects[i].view.isovalue = 0.6;
    }
    expect_right(scene, "mode " + std::to_string(int(mode)), 38);
  }
  expect_right(row_of({scene::Mode::maximum, scene::Mode::mean, scene::Mode::minimum}, 1.2), "in a row", 50);
}

TEST(Objects, without_levels_of_detail_and_in_parallel_projection) {
  ObjectScene scene = random_scene(11, 6, 0.6);
  scene.view.level_of_detail = false;
  expect_right(scene, "finest", 55);
  scene.view.level_of_detail = true;
  scene.view.camera.height_world = 2.5;
  expect_right(scene, "orthographic", 50);
}

TEST(Objects, from_within) {
  ObjectScene scene = random_scene(13, 8, 0.6);
  scene.view.camera.target = scene.view.camera.eye + Vec3d(0.1, -1, 0.3);
  scene.view.camera.eye = {0.05, 0.1, -0.05};
  scene.view.camera.fov_degrees = 70;
  expect_right(scene, "from within", 45);
}

TEST(Objects, are_the_same_bits_however_rays_are_interrupted) {
  ObjectScene scene = random_scene(17, 6, 0.5);
  scene.objects[1].view.mode = scene::Mode::maximum;
  scene.objects[3].view.mode = scene::Mode::isosurface;
  scene.objects[3].view.isovalue = 0.7;
  for (const bool one_ray_at_a_time : {false, true}) {
    HowRendered at_once, often;
    at_once.one_ray_at_a_time = often.one_ray_at_a_time = one_ray_at_a_time;
    often.withheld = 0.7;
    often.device = exec::Device::cpu(3);
    often.pools = {120, 60};
    ResidentScene first(scene, at_once), second(scene, often);
    const render::Picture picture = first.render_exact();
    EXPECT_EQ(second.render_exact().rgba, picture.rgba);
    EXPECT_GT(second.passes(), 2 * first.passes());
  }
}

TEST(Objects, that_do_not_overlap_show_what_each_shows_alone) {
  const ObjectScene both = row_of({scene::Mode::composite, scene::Mode::isosurface}, 1.2);
  const render::Picture picture = ResidentScene(both, {}).render_exact();
  for (const std::size_t which : {0, 1}) {
    ObjectScene alone = both;
    alone.objects = {both.objects[which]};
    const render::Picture shown = ResidentScene(alone, {}).render_exact();
    std::size_t seen = 0;
    for (std::uint32_t y = 0; y < picture.height; ++y) {
      for (std::uint32_t x = 0; x < picture.width; ++x) {
        const std::size_t pixel = 4 * (std::size_t(y) * picture.width + x);
        if (shown.rgba[pixel] == both.view.background.x) continue;
        ++seen;
        for (std::size_t c = 0; c < 4; ++c) ASSERT_EQ(shown.rgba[pixel + c], picture.rgba[pixel + c]);
      }
    }
    EXPECT_GT(seen, 150u);
  }
}

TEST(Objects, draw_the_previews_that_one_ray_at_a_time_draws) {
  ObjectScene scene = random_scene(19, 5, 0.7);
  scene.objects[2].view.mode = scene::Mode::mean;
  ResidentScene resident(scene, {});
  const exec::Device cpu = exec::Device::cpu();
  const std::size_t rays = std::size_t(scene.view.width) * scene.view.height;
  exec::Buffer<render::PreviewPixel> plain(cpu, rays), tiles_drawn(cpu, rays);
  std::uint64_t lacking = 0;
  for (std::uint32_t number = 1; number <= 6; ++number) {
    const std::uint32_t block = number % 2 == 0 ? 4 : 1;
    const exec::TileGrid grid{(scene.view.width + block - 1) / block, (scene.view.height + block - 1) / block,
                              block > 1 ? 16u : 64u};
    exec::Buffer<std::uint32_t> tiles(cpu, grid.tiles());
    for (std::uint32_t t = 0; t < grid.tiles(); ++t) tiles.view()[t] = t;
    render::Pass pass = resident.next_pass();
    const render::TilesMarch march{pass, grid, tiles.view(), exec::no_deadline()};
    for (exec::Buffer<render::PreviewPixel>* const pixels : {&plain, &tiles_drawn}) {
      pass.one_ray_at_a_time = pixels == &plain;
      EXPECT_TRUE(render::march_preview(cpu, {march, block, number, resident.film().rays(), pixels->view()}));
    }
    for (std::uint32_t y = 0; y < scene.view.height; y += block) {
      for (std::uint32_t x = 0; x < scene.view.width; x += block) {
        const std::size_t index = std::size_t(y) * scene.view.width + x;
        const render::PreviewPixel a = plain.view()[index], b = tiles_drawn.view()[index];
        ASSERT_EQ(a.generation, number);
        ASSERT_EQ(a.wanted, b.wanted) << "pass " << number << " at " << x << " " << y;
        ASSERT_EQ(a.resident, b.resident);
        ASSERT_EQ(a.worst_lack, b.worst_lack);
        ASSERT_NEAR(a.opacity, b.opacity, 1.0f / 255);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(a.color[c], b.color[c], 1.0f / 255);
        const render::PreviewPixel alone = render::preview_ray(pass, x, y);
        ASSERT_EQ(alone.color, a.color);
        lacking += a.wanted - a.resident;
      }
    }
    resident.produce_lacking();
  }
  EXPECT_GT(lacking, 100u);
}

TEST(Objects, are_named_where_half_of_a_pixel_is_seen) {
  ObjectScene scene = row_of({scene::Mode::isosurface, scene::Mode::composite, scene::Mode::isosurface}, 1.2);
  scene.objects[1].view.functions[0].opacities = {{0, 0}, {1, 0.02}};
  ResidentScene resident(scene, {});
  resident.render_exact();
  const render::Pass pass = resident.next_pass();
  const auto at = [&](double x_world) {
    const double pixels_a_unit = 80 / (2 * 4 * std::tan(15 * M_PI / 180));
    return render::reach(pass, 75 + x_world * pixels_a_unit - 0.5, 39.5, 0.5f);
  };
  // Of a ball exp(-12 r^2) the surface of 0.6 is at this radius.
  const double radius = std::sqrt(-std::log(0.6) / 12);
  EXPECT_EQ(at(-1.2).object, 0);
  EXPECT_NEAR(at(-1.2).distance, std::hypot(4, 1.2) - radius, 0.01);
  EXPECT_EQ(at(0).object, -1) << "hides too little";
  EXPECT_EQ(at(0).distance, INFINITY);
  EXPECT_EQ(at(1.2).object, 2);
  // One within the haze of another.
  scene.objects[2].view.mode = scene::Mode::composite;
  scene.objects[2].producer = scene.objects[0].producer;
  ResidentScene overlapping(scene, {});
  overlapping.render_exact();
  const render::RayReach reach = render::reach(
      overlapping.next_pass(), 75 - 1.2 * 80 / (8 * std::tan(15 * M_PI / 180)) - 0.5, 39.5, 0.5f);
  EXPECT_TRUE(reach.object == 0 || reach.object == 2);
  EXPECT_LE(reach.distance, std::hypot(4, 1.2) - radius + 0.01);
}

TEST(Objects, of_a_world_are_what_a_viewer_renders) {
  ObjectScene scene = random_scene(29, 5, 0.5);
  scene.objects[1].view.mode = scene::Mode::maximum;
  scene.objects[4].view.mode = scene::Mode::isosurface;
  scene.objects[4].view.isovalue = 0.7;
  const auto cache = engine::Cache::create(exec::Device::cpu(3), {}).value();
  std::vector<engine::Object> objects;
  for (const SceneObject& object : scene.objects) {
    objects.push_back({cache->open(object.producer).value(), {}, object.view});
  }
  engine::Viewer viewer(cache);
  render::View view = scene.view;
  view.lighting.enabled = false;
  ASSERT_TRUE(viewer.look(view, engine::World::make(std::move(objects)).value()).ok());
  while (!viewer.converged()) ASSERT_TRUE(viewer.render_for(std::chrono::milliseconds(5)).ok());
  EXPECT_EQ(viewer.picture().rgba, ResidentScene(scene, {}).render_exact().rgba);

  std::vector<std::int32_t> seen(std::size_t(view.width) * view.height);
  std::vector<float> depth(seen.size());
  ASSERT_TRUE(viewer.picture({.depth = {depth}, .object = {seen}}).ok());
  std::vector<std::size_t> count(6);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    ASSERT_EQ(seen[i] < 0, std::isinf(depth[i]));
    ++count.at(std::size_t(seen[i] + 1));
  }
  EXPECT_GT(count[0], 100u) << "nothing is seen";
  EXPECT_GT(count[5], 100u) << "the surface is seen";
}

TEST(Objects, are_found_by_the_tiles_that_they_are_on) {
  std::mt19937 random(23);
  ObjectScene scene = random_scene(23, 60, 6.0);
  scene.view.width = 300;
  scene.view.height = 200;
  std::vector<std::unique_ptr<render::Frame>> frames;
  std::vector<render::ObjectView> views;
  for (const SceneObject& object : scene.objects) {
    frames.push_back(std::make_unique<render::Frame>(
        render::Frame::make(exec::Device::cpu(), scene.view_of(object), object.producer->description())
            .value()));
    views.emplace_back();
    views.back().frame = frames.back()->view();
  }
  const render::FilmView film = render::film_of(scene.view).value();
  const render::ObjectTiles tiles(film, views);
  std::size_t met = 0, listed = 0;
  for (std::int32_t y = 0; y < 200; y += 7) {
    for (std::int32_t x = 0; x < 300; x += 7) {
      const std::vector<std::uint32_t> here = tiles.objects_in({x, x, y, y});
      listed += here.size();
      for (std::uint32_t i = 0; i < views.size(); ++i) {
        if (render::ObjectRay(views[i].frame, film.ray(x, y)).inside.empty()) continue;
        ++met;
        EXPECT_TRUE(std::binary_search(here.begin(), here.end(), i)) << i << " at " << x << " " << y;
      }
    }
  }
  EXPECT_GT(met, 400u);
  EXPECT_LT(listed, 4 * met) << "rectangles are little larger than what is in them";
}

TEST(Objects, too_many_that_project_are_an_error) {
  const exec::Device cpu = exec::Device::cpu();
  EXPECT_TRUE(render::check_objects(cpu, 10000, 16).ok());
  EXPECT_EQ(render::check_objects(cpu, 30, 17).error().message,
            "objects: at most 16 may show a greatest, least or mean value, not 17");
}

}  // namespace
}  // namespace gvx::tests
