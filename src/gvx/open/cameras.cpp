#include "gvx/open/cameras.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "gvx/core/box_parts.h"
#include "gvx/open/scene_view.h"
#include "gvx/open/visible_bounds.h"
#include "gvx/render/frame/frame.h"
#include "gvx/scene/framing.h"

namespace gvx::open {
namespace {

/// What cameras frame where nothing is known of the volume.
const scene::Framing kAnyFraming{{{0, 0, 0}, {1, 1, 1}}, {}, {}, scene::Stance::z_up, 1};

/// In tree space, what can be seen of a scene that is complete but for its camera.
Result<VisibleBounds> visible_part(const scene::SceneFile& scene, const OpenVolume& volume,
                                   const FieldNaming& naming) {
  const produce::TreeDescription& tree = volume.producer->description();
  const Box3d all = tree.bounds.value_or(tree.extent);
  const Box3d shown = intersect(all, box_part(tree.extent, *scene.clip));
  if (shown.empty()) return VisibleBounds{all, {}};
  if (!tree.outline.empty()) return VisibleBounds{shown, tree.outline};
  // What is made, not stored, tells less than what it will be.
  if (!tree.exact_ranges || scene::projects(*scene.mode)) return VisibleBounds{shown, {}};
  scene::SceneFile seen_somehow = scene;
  seen_somehow.camera = scene::CameraParts(scene::Camera());
  GVX_ASSIGN(const render::View view, make_view(seen_somehow, volume, naming));
  GVX_ASSIGN(const auto frame, render::Frame::make(exec::Device::cpu(1), view, tree));
  return visible_bounds(*volume.producer, frame.view().visibility, shown);
}

/// Of a scene that is complete but for its camera.
Result<scene::Framing> framing_of(const scene::SceneFile& scene, const OpenVolume& volume,
                                  const FieldNaming& naming) {
  const produce::TreeDescription& tree = volume.producer->description();
  scene::Framing framing;
  GVX_ASSIGN(const VisibleBounds visible, visible_part(scene, volume, naming));
  framing.box = visible.box;
  framing.points = visible.points;
  framing.box_to_world = tree.tree_to_world;
  framing.stance =
      scene.up_axis ? scene::stance_of(*scene.up_axis, false) : scene::stance_of(tree.up, tree.anatomical);
  framing.aspect = double(*scene.width) / double(*scene.height);
  return framing;
}

/// The camera of a scene, and what of it was said.
struct StatedCamera {
  scene::Camera camera;
  Vec3d up;                ///< before another was chosen that does not point along the view
  bool has_up = false;     ///< was it given?
  bool has_place = false;  ///< eye and target: the framing does not matter
};

Result<StatedCamera> stated_camera(const scene::SceneFile& scene, const scene::Framing& framing) {
  const scene::CameraParts& parts = scene.camera;
  if (parts.up && !(length(*parts.up) > 0)) return Error{"camera: up: expected a direction, found 0,0,0"};
  return StatedCamera{scene::complete_camera(parts, framing),
                      parts.up.value_or(scene::standard_outlook(framing.stance).up), parts.up.has_value(),
                      parts.eye && (parts.target || parts.origin)};
}

/// The camera of a key frame: what it leaves out is that of all of them.
scene::Camera key_camera(const scene::KeyFrameParts& key, const StatedCamera& all) {
  scene::Camera camera = key.camera.over(all.camera);
  if (key.camera.up || all.has_up) return camera;
  camera.up = all.up;
  return scene::with_fitting_up(camera);
}

Status check_view(const scene::Camera& camera) {
  GVX_ASSIGN(const auto view, scene::make_view(camera, 1, 1));
  (void)view;
  return {};
}

/// With this framing.
Status complete_cameras(scene::SceneFile& scene, const scene::Framing& framing) {
  GVX_ASSIGN(const StatedCamera stated, stated_camera(scene, framing));
  for (scene::KeyFrameParts& key : scene.camera_path)
    key.camera = scene::CameraParts(key_camera(key, stated));
  if (scene.camera_path.empty()) GVX_TRY(check_view(stated.camera));
  scene.camera = scene::CameraParts(stated.camera);
  return {};
}

}  // namespace

Status check_cameras(const scene::SceneFile& scene) {
  GVX_ASSIGN(const StatedCamera stated, stated_camera(scene, kAnyFraming));
  const std::vector<scene::KeyFrameParts>& keys = scene.camera_path;
  if (keys.empty()) return stated.has_place ? check_view(stated.camera) : Status();
  std::vector<scene::KeyFrame> path;
  for (const scene::KeyFrameParts& key : keys) {
    scene::Camera camera = key_camera(key, stated);
    const bool has_place = (key.camera.eye && (key.camera.target || key.camera.origin)) || stated.has_place;
    if (!has_place) {
      // Any place that is a view will do.
      camera.eye = {1, 0, 0};
      camera.target = {0, 0, 0};
      camera.up = {0, 0, 1};
    }
    path.push_back({key.frame, camera});
  }
  GVX_ASSIGN(const auto checked, scene::CameraPath::create(std::move(path)));
  (void)checked;
  return {};
}

Status complete_cameras(scene::SceneFile& scene, const OpenVolume& volume, const FieldNaming& naming) {
  GVX_ASSIGN(const scene::Framing framing, framing_of(scene, volume, naming));
  return complete_cameras(scene, framing);
}

Status complete_cameras(scene::SceneFile& scene, const std::vector<PlacedBox>& boxes) {
  scene::Framing framing;
  for (const PlacedBox& placed : boxes) {
    for (int corner = 0; corner < 8; ++corner) {
      framing.points.push_back(placed.to_world.point(box_corner(placed.box, corner)));
    }
  }
  framing.box = {framing.points[0], framing.points[0]};
  for (const Vec3d& p : framing.points) {
    for (int axis = 0; axis < 3; ++axis) {
      framing.box.minimum[axis] = std::min(framing.box.minimum[axis], p[axis]);
      framing.box.maximum[axis] = std::max(framing.box.maximum[axis], p[axis]);
    }
  }
  framing.stance = scene::stance_of(scene.up_axis.value_or(UpAxis::z), false);
  framing.aspect = double(*scene.width) / double(*scene.height);
  return complete_cameras(scene, framing);
}

Result<std::optional<scene::CameraPath>> camera_path(const scene::SceneFile& scene) {
  if (scene.camera_path.empty()) return std::optional<scene::CameraPath>();
  std::vector<scene::KeyFrame> keys;
  for (const scene::KeyFrameParts& key : scene.camera_path) {
    keys.push_back({key.frame, key.camera.over({})});
  }
  GVX_ASSIGN(auto path, scene::CameraPath::create(std::move(keys)));
  return std::optional<scene::CameraPath>(std::move(path));
}

}  // namespace gvx::open
