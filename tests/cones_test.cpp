/// \file
/// Rays are cones that begin anywhere and widen as they like: those of a picture are only one kind.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "object_scenes.h"

namespace gvx::tests {
namespace {

/// One object before a camera; levels are blended in most of it.
ObjectScene one_object(std::uint32_t seed) {
  ObjectScene scene = random_scene(seed, 1, 0.1);
  scene.view.width = 60;
  scene.view.height = 45;
  return scene;
}

void expect_same(const render::RayState& a, const render::RayState& b, double most, const char* what) {
  EXPECT_NEAR(a.opacity, b.opacity, most) << what;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a.color[c], b.color[c], most) << what;
}

TEST(Cones, are_the_same_wherever_they_are_told_from) {
  for (const std::uint32_t seed : {1u, 2u, 5u, 8u}) {
    const ObjectScene scene = one_object(seed);
    ResidentScene resident(scene, {});
    const render::FilmView film = render::film_of(scene.view).value();
    const ConeShape cones = film.camera.cones();
    const render::Bundle of_eye = resident.bundle_at(film.camera.eye, cones);
    const Vec3d elsewhere = film.camera.eye + 0.3 * film.camera.right - 0.2 * film.camera.forward;
    const render::Bundle beside = resident.bundle_at(elsewhere, cones);
    // A ray that sets out later is as wide there as it would be.
    const double ahead = 0.4;
    const render::Bundle later = resident.bundle_at(film.camera.eye, {ahead * cones.growth, cones.growth});
    int seen = 0;
    for (std::uint32_t y = 0; y < film.height; y += 4) {
      for (std::uint32_t x = 0; x < film.width; x += 4) {
        const Ray ray = film.ray(x, y).ray;
        const render::RayState own = resident.march_ray(of_eye, {ray});
        seen += own.opacity > 0.05f ? 1 : 0;
        // Steps that begin at another distance by rounding may end in another voxel.
        const Vec3d from_there = film.camera.eye + ray.origin - elsewhere;
        expect_same(own, resident.march_ray(beside, {{from_there, ray.direction}}), 1e-3, "beside the eye");
        expect_same(own, resident.march_ray(later, {{ahead * ray.direction, ray.direction}}), 1e-3, "ahead");
      }
    }
    EXPECT_GT(seen, 5) << seed;
  }
}

TEST(Cones, that_do_not_grow_are_those_of_parallel_rays) {
  ObjectScene scene = one_object(3);
  scene.view.camera.height_world = 2.5;
  ResidentScene resident(scene, {});
  const render::FilmView film = render::film_of(scene.view).value();
  const render::Bundle bundle =
      resident.bundle_at(film.camera.eye + Vec3d(0.1, 0.2, 0.3), {film.camera.pixel, 0});
  const render::Picture picture = resident.render_exact();
  double most = 0;
  for (std::uint32_t y = 0; y < film.height; y += 3) {
    for (std::uint32_t x = 0; x < film.width; x += 3) {
      Ray ray = film.ray(x, y).ray;
      ray.origin = ray.origin - Vec3d(0.1, 0.2, 0.3);
      const render::RayState state = resident.march_ray(bundle, {ray});
      const float* const pixel = &picture.rgba[4 * film.index(x, y)];
      for (int c = 0; c < 3; ++c) {
        const float shown = state.color[c] + (1 - state.opacity) * scene.view.background[c];
        most = std::max(most, std::fabs(double(shown) - double(pixel[c])));
      }
    }
  }
  EXPECT_LT(most, 2e-3);
}

TEST(Cones, that_are_wide_take_few_samples_of_coarse_levels) {
  ObjectScene scene = one_object(1);
  Affine3 place;
  place.origin = Vec3d(-0.5);
  scene.objects[0] = object_of(soft_ball(Vec3d(0.5), 10), place, {VoxelType::f32, 2, 8, 5});
  // Something is seen in all of it: what of it is hidden differs from level to level.
  scene.objects[0].view.functions = {{{{0, {1, 0.5, 0.2}}}, {{0, 0.05}, {1, 0.3}}, 0.1}};
  const render::FilmView film = render::film_of(scene.view).value();
  const auto samples = [&](double wider) {
    ResidentScene resident(scene, {});
    const ConeShape cones{0, wider * film.camera.pixel};
    const render::Bundle bundle = resident.bundle_at(film.camera.eye, cones);
    std::uint64_t sum = 0;
    double opacity = 0;
    for (std::uint32_t y = 0; y < film.height; y += 4) {
      for (std::uint32_t x = 0; x < film.width; x += 4) {
        const render::RayState state = resident.march_ray(bundle, film.ray(x, y));
        sum += state.samples;
        opacity += double(state.opacity);
      }
    }
    return std::pair(double(sum), opacity);
  };
  const auto [many, opacity] = samples(0.25);
  const auto [few, coarse_opacity] = samples(2);
  EXPECT_LT(few, 0.5 * many);
  EXPECT_NEAR(coarse_opacity, opacity, 0.1 * opacity);
}

}  // namespace
}  // namespace gvx::tests
