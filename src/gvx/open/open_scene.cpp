#include "gvx/open/open_scene.h"

#include <algorithm>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "gvx/core/box_parts.h"
#include "gvx/open/cameras.h"
#include "gvx/open/functions.h"
#include "gvx/open/scene_view.h"
#include "gvx/render/frame/frame.h"

namespace gvx::open {
namespace {

/// What can be said of a scene before its volume is opened.
Status check_before_opening(const scene::SceneFile& scene, const OpenOptions& options) {
  GVX_TRY(check_function_files(scene, options));
  return check_cameras(scene);
}

/// And before a volume of these voxels is built: an error where they cannot be shown so.
Status check_before_building(const scene::SceneFile& scene, const VoxelFormat& format,
                             const FieldNaming& naming) {
  GVX_TRY(check_isovalue(scene, naming));
  GVX_TRY(check_functions(scene, format, naming));
  render::View view;
  view.mode = scene.mode.value_or(view.mode);
  view.classification = scene.classification.value_or(view.classification);
  view.lighting = scene.lighting.over(view.lighting);
  view.functions = {{{{0, {}}}, {{0, 0}}}};
  tree::TreeDescription tree;
  tree.format = format;
  GVX_ASSIGN(const auto frame, render::Frame::make(exec::Device::cpu(1), view, tree));
  (void)frame;
  return {};
}

/// Opens the volume of a scene that was checked, after what can be checked when its voxels are known.
Result<OpenVolume> open_volume_of(const scene::SceneFile& scene, const OpenOptions& options) {
  OpenOptions with_checks = options;
  with_checks.before_build = [&](const VoxelFormat& format) -> Status {
    GVX_TRY(check_before_building(scene, format, options.naming));
    return options.before_build(format);
  };
  return open_volume(scene, with_checks);
}

/// A scene of one of its objects alone.
scene::SceneFile scene_of(scene::SceneFile scene, const scene::ObjectParts& object) {
  scene.objects.clear();
  static_cast<scene::ObjectParts&>(scene) = object;
  return scene;
}

/// The scene itself, or that of its only object.
scene::SceneFile scene_of_one(const scene::SceneFile& scene) {
  return scene.objects.empty() ? scene : scene_of(scene, scene.objects[0]);
}

bool name_the_same_volume(const scene::ObjectParts& a, const scene::ObjectParts& b) {
  const auto labels = [](const scene::ObjectParts& object) {
    return object.labels ? std::optional(object.labels->enabled) : std::nullopt;
  };
  return a.volume == b.volume && a.raw == b.raw && a.series == b.series && a.time == b.time &&
         a.even_slices == b.even_slices && a.generate == b.generate && labels(a) == labels(b);
}

/// Opens the object that `one` is the scene of, unless the volume of one before it is the same.
Result<OpenObject> open_object(scene::SceneFile one, std::span<const scene::PlacedObject> before,
                               std::span<const OpenObject> opened, const OpenOptions& options) {
  GVX_TRY(check_function_files(one, options));
  OpenObject object;
  const auto same = std::find_if(before.begin(), before.end(), [&](const scene::PlacedObject& other) {
    return name_the_same_volume(other, one);
  });
  if (same != before.end()) {
    object.volume = opened[static_cast<std::size_t>(same - before.begin())].volume;
  } else {
    GVX_ASSIGN(object.volume, open_volume_of(one, options));
  }
  GVX_TRY(complete_look(one, object.volume, options.naming));
  GVX_ASSIGN(object.look, make_view(one, object.volume, options.naming));
  return object;
}

/// Of a scene that was checked.
Result<OpenScene> show(OpenVolume volume, scene::SceneFile scene, const OpenOptions& options) {
  GVX_TRY(complete_look(scene, volume, options.naming));
  GVX_TRY(complete_cameras(scene, volume, options.naming));
  OpenScene opened;
  GVX_ASSIGN(opened.path, camera_path(scene));
  GVX_ASSIGN(opened.view, make_view(scene, volume, options.naming));
  if (opened.path) opened.view.camera = opened.path->key_frames().front().camera;
  warn_of_close_points(volume.producer->description(), opened.view.functions, options.warn);
  opened.objects = {{volume, opened.view, {}}};
  opened.volume = std::move(volume);
  opened.scene = std::move(scene);
  return opened;
}

/// Several objects, or one that is moved.
Result<OpenScene> open_placed_objects(scene::SceneFile scene, const OpenOptions& options) {
  OpenScene opened;
  GVX_ASSIGN(opened.objects, open_objects(scene, options));
  opened.volume = opened.objects[0].volume;
  // What the objects have in common is completed as that of the first.
  scene::SceneFile first = scene_of_one(scene);
  const bool has_volumes =
      std::any_of(opened.objects.begin(), opened.objects.end(),
                  [](const OpenObject& object) { return !object.volume.producer->description().surface; });
  if (has_volumes && !first.antialias) first.antialias = render::View().antialias;
  GVX_TRY(complete_look(first, opened.volume, options.naming));
  std::vector<PlacedBox> boxes;
  for (const OpenObject& object : opened.objects) {
    const produce::TreeDescription& tree = object.volume.producer->description();
    const Box3d all = tree.bounds.value_or(tree.extent);
    const Box3d shown = intersect(all, box_part(tree.extent, object.look.clip));
    boxes.push_back({shown.empty() ? all : shown, object.to_world * tree.tree_to_world});
  }
  GVX_TRY(complete_cameras(first, boxes));
  GVX_ASSIGN(opened.path, camera_path(first));
  GVX_ASSIGN(opened.view, make_view(first, opened.volume, options.naming));
  if (opened.path) opened.view.camera = opened.path->key_frames().front().camera;
  // Instances are warned of once.
  std::set<std::string> said;
  const auto warn_once = [&](const std::string& message) {
    if (said.insert(message).second) options.warn(message);
  };
  for (const OpenObject& object : opened.objects) {
    warn_of_close_points(object.volume.producer->description(), object.look.functions, warn_once);
  }
  scene.camera = first.camera;
  scene.camera_path = first.camera_path;
  opened.scene = std::move(scene);
  return opened;
}

}  // namespace

bool has_placed_objects(const scene::SceneFile& scene) {
  return scene.objects.size() > 1 ||
         (scene.objects.size() == 1 && scene.objects[0].transform != scene::TransformParts());
}

Result<OpenScene> open_scene(const scene::SceneFile& scene, const OpenOptions& options) {
  const scene::SceneFile one = scene_of_one(scene);
  GVX_TRY(check_before_opening(one, options));
  if (has_placed_objects(scene)) return open_placed_objects(scene, options);
  GVX_ASSIGN(OpenVolume volume, open_volume_of(one, options));
  return show(std::move(volume), one, options);
}

Result<OpenScene> look_at(const OpenVolume& volume, const scene::SceneFile& scene,
                          const OpenOptions& options) {
  if (has_placed_objects(scene))
    return Error{"objects: a single volume is shown by itself; expected one object"};
  const scene::SceneFile one = scene_of_one(scene);
  GVX_TRY(check_before_opening(one, options));
  return show(volume, one, options);
}

Result<std::vector<OpenObject>> open_objects(const scene::SceneFile& scene, const OpenOptions& options) {
  std::vector<scene::PlacedObject> objects = scene.objects;
  if (objects.empty()) objects.push_back({scene, {}});
  // There may be thousands of them: what they have in common is copied without them.
  scene::SceneFile common = scene;
  common.objects.clear();
  std::vector<OpenObject> opened;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    auto object = open_object(scene_of(common, objects[i]), std::span(objects).first(i), opened, options);
    if (!object.ok()) return Error{"objects[" + std::to_string(i) + "]: " + object.error().message};
    object.value().to_world = objects[i].transform.to_world();
    opened.push_back(std::move(object).value());
  }
  return opened;
}

}  // namespace gvx::open
