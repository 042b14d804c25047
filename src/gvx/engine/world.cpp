#include "gvx/engine/world.h"

#include <algorithm>
#include <string>
#include <utility>

#include "gvx/core/box_parts.h"

namespace gvx::engine {

Result<std::shared_ptr<const World>> World::make(std::vector<Object> objects) {
  if (objects.empty()) return Error{"objects: there are none"};
  auto world = std::make_shared<World>();
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::string name = "objects[" + std::to_string(i) + "]";
    const bool is_surface = objects[i].surface != nullptr;
    if (!is_surface && objects[i].volume == nullptr) return Error{name + ": no volume"};
    if (is_surface && objects[i].volume != nullptr) {
      return Error{name + ": expected a volume or a surface, found both"};
    }
    const tree::TreeDescription& tree = is_surface ? objects[i].surface->tree() : objects[i].volume->tree();
    const Affine3 place = objects[i].transform * tree.tree_to_world;
    if (!check_placement(place).ok()) return Error{name + ".transform: it has no usable inverse"};
    world->add(std::move(objects[i]));
  }
  return std::shared_ptr<const World>(std::move(world));
}

void World::add(Object object) {
  tree::TreeDescription tree = object.surface != nullptr ? object.surface->tree() : object.volume->tree();
  tree.histograms.clear();
  tree.outline.clear();
  tree.tree_to_world = object.transform * tree.tree_to_world;
  trees_.push_back(std::move(tree));
  if (object.surface != nullptr) {
    surfaces_.push_back(objects_.size());
    kind_of_.push_back(0);
    objects_.push_back(std::move(object));
    return;
  }
  auto volume = std::find(volumes_.begin(), volumes_.end(), object.volume.get());
  if (volume == volumes_.end()) volume = volumes_.insert(volume, object.volume.get());
  const auto index = static_cast<std::size_t>(volume - volumes_.begin());
  const auto same = std::find_if(kinds_.begin(), kinds_.end(), [&](const Kind& kind) {
    return kind.volume == index && objects_[kind.object].shown.sees_like(object.shown);
  });
  kind_of_.push_back(static_cast<std::size_t>(same - kinds_.begin()));
  if (same == kinds_.end()) kinds_.push_back({index, objects_.size()});
  projecting_ += scene::projects(object.shown.mode) ? 1 : 0;
  objects_.push_back(std::move(object));
}

bool World::out_of_sight(std::size_t object, const scene::CameraView& camera) const {
  const tree::TreeDescription& tree = trees_[object];
  const double wide = camera.half_width * camera.pixel, high = camera.half_height * camera.pixel;
  // Behind the eye, and beyond each side of the picture: is every corner?
  bool behind = !camera.orthographic, left = true, right = true, above = true, below = true;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d p = box_corner(tree.extent, corner);
    const Vec3d d = tree.tree_to_world.point(p) - camera.eye;
    const double x = dot(d, camera.right), y = dot(d, camera.up), z = dot(d, camera.forward);
    const double across = camera.orthographic ? wide : z * wide, up = camera.orthographic ? high : z * high;
    behind = behind && z <= 0;
    left = left && x < -across;
    right = right && x > across;
    above = above && y > up;
    below = below && y < -up;
  }
  return behind || left || right || above || below;
}

}  // namespace gvx::engine
