#include "cameras.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "gvx/scene/framing.h"

namespace gvx::bench {
namespace {

/// Vertices that stand for all.
std::vector<Vec3d> some_places(const Model& model) {
  constexpr std::size_t kMost = 100000;
  std::vector<Vec3d> places;
  for (std::size_t i = 0; i < model.places.size(); i += 1 + model.places.size() / kMost) {
    places.emplace_back(model.places[i]);
  }
  return places;
}

constexpr double kNearer = 4;

}  // namespace

scene::Camera camera_that_fits(const Model& model, double aspect) {
  scene::Framing framing;
  framing.box = model.bounds;
  framing.points = some_places(model);
  framing.stance = scene::stance_of(model.up, false);
  framing.aspect = aspect;
  framing.fill = 1;
  return scene::complete_camera({}, framing);
}

scene::Camera camera_far(const scene::Camera& fits) {
  scene::Camera camera = fits;
  camera.eye = fits.target + 2.0 * (fits.eye - fits.target);
  return camera;
}

scene::Camera camera_near(const scene::Camera& fits, Vec3d place) {
  scene::Camera camera = fits;
  camera.target = place;
  camera.eye = place + (fits.eye - place) / kNearer;
  return camera;
}

scene::Camera camera_grazing(const scene::Camera& fits, Vec3d place, const Model& model) {
  const double distance = length(fits.eye - place) / kNearer;
  std::size_t nearest = 0;
  double least = INFINITY;
  for (std::size_t i = 0; i < model.places.size(); ++i) {
    const double far = length(Vec3d(model.places[i]) - place);
    if (far < least) least = far, nearest = i;
  }
  Vec3d normal(model.normals[nearest]);
  if (dot(normal, fits.eye - place) < 0) normal = -normal;
  const Vec3d aside = normalize(cross(normal, std::fabs(normal.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)));
  const Vec3d beside = cross(normal, aside);
  const std::vector<Vec3d> places = some_places(model);
  scene::Camera camera = fits;
  camera.target = place;
  camera.up = normal;
  constexpr int kWays = 24;
  constexpr double kAbove = 8 * M_PI / 180, kClear = 0.15;  // of the distance
  std::size_t fewest = SIZE_MAX;
  for (int i = 0; i < kWays; ++i) {
    const double turn = 2 * M_PI * i / kWays;
    const Vec3d way =
        std::cos(kAbove) * (std::cos(turn) * aside + std::sin(turn) * beside) + std::sin(kAbove) * normal;
    const auto between = static_cast<std::size_t>(std::count_if(places.begin(), places.end(), [&](Vec3d at) {
      const double along = dot(at - place, way);
      return along > 2 * kClear * distance && along < (1 + kClear) * distance &&
             length(at - place - along * way) < kClear * distance;
    }));
    if (between >= fewest) continue;
    fewest = between;
    camera.eye = place + distance * way;
  }
  return camera;
}

}  // namespace gvx::bench
