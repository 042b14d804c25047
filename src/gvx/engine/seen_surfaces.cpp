#include "gvx/engine/seen_surfaces.h"

#include <algorithm>
#include <cmath>

#include "gvx/core/box_parts.h"

namespace gvx::engine {
namespace {

surface::SurfaceView surface_view(const render::View& view, const render::FilmView& film) {
  surface::SurfaceView seen;
  seen.camera = film.camera;
  seen.width = film.width;
  seen.height = film.height;
  seen.lighting = scene::place_lights(view.lighting, film.camera.forward, film.camera.right, film.camera.up);
  // Of volumes as many voxels are across a cone as `detail` says, and two by default.
  constexpr double kVoxels = 2;
  seen.widest_cell = view.level_of_detail ? surface::kWidestCell * kVoxels / view.detail : 0;
  seen.overlay = view.overlay;
  return seen;
}

std::vector<surface::SurfaceInstance> instances_of(const World& world, const render::FilmView& film,
                                                   std::vector<Surface*>& surfaces) {
  std::vector<surface::SurfaceInstance> instances;
  for (const std::size_t object : world.surfaces()) {
    if (world.out_of_sight(object, film.camera)) continue;
    Surface* const surface = world.objects()[object].surface.get();
    const tree::TreeDescription& tree = world.tree(object);
    const double cells = std::ldexp(double(tree.m), static_cast<int>(tree.max_level));
    surfaces.push_back(surface);
    instances.push_back({&surface->residency(), tree.max_level + 1,
                         tree.tree_to_world * scaling(Vec3d(1 / cells)), static_cast<std::int32_t>(object)});
  }
  return instances;
}

}  // namespace

Status check_distance(const render::FilmView& film, const World& world) {
  constexpr double kRounding = 6e-8, kMostOfPixel = 0.1;
  const Affine3 to_camera = surface::world_to_camera(film.camera);
  const surface::FilmPlane plane(film.camera, film.width, film.height);
  for (const std::size_t object : world.surfaces()) {
    const tree::TreeDescription& tree = world.tree(object);
    double nearest = INFINITY, farthest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d place = tree.tree_to_world.point(box_corner(tree.bounds.value_or(tree.extent), corner));
      const double depth = to_camera.point(place).z;
      nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
    }
    if (!(nearest > 0) || world.out_of_sight(object, film.camera)) continue;
    if (farthest * kRounding > kMostOfPixel * plane.width_at(nearest)) {
      return Error{
          "camera: surfaces cannot be told apart from so far away; expected an eye that is nearer, or a "
          "wider "
          "angle"};
    }
  }
  return {};
}

SeenSurfaces::SeenSurfaces(const exec::Device& cpu, const render::View& view, const render::FilmView& film,
                           const World& world)
    : drawing_(cpu, surface_view(view, film), instances_of(world, film, surfaces_)) {}

void SeenSurfaces::see(const render::View& view, const render::FilmView& film, const World& world) {
  surfaces_.clear();
  const auto instances = instances_of(world, film, surfaces_);
  drawing_.see(surface_view(view, film), instances);
}

std::vector<Cache::SurfaceElement> SeenSurfaces::elements_of(
    const std::vector<surface::LackingElement>& lacking) const {
  std::vector<Cache::SurfaceElement> elements;
  elements.reserve(lacking.size());
  for (const surface::LackingElement& element : lacking) {
    elements.push_back({surfaces_[element.instance]->residency().key_of(element),
                        SurfaceResidency::bytes_of(element.bytes)});
  }
  return elements;
}

}  // namespace gvx::engine
