#include "gvx/open/open_scene.h"

#include <utility>

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

/// Of a scene that was checked.
Result<OpenScene> show(OpenVolume volume, scene::SceneFile scene, const OpenOptions& options) {
  GVX_TRY(complete_look(scene, volume, options.naming));
  GVX_TRY(complete_cameras(scene, volume, options.naming));
  OpenScene opened;
  GVX_ASSIGN(opened.path, camera_path(scene));
  GVX_ASSIGN(opened.view, make_view(scene, volume, options.naming));
  if (opened.path) opened.view.camera = opened.path->key_frames().front().camera;
  warn_of_close_points(volume.producer->description(), opened.view.functions, options.warn);
  opened.volume = std::move(volume);
  opened.scene = std::move(scene);
  return opened;
}

}  // namespace

Result<OpenScene> open_scene(const scene::SceneFile& scene, const OpenOptions& options) {
  GVX_TRY(check_before_opening(scene, options));
  OpenOptions with_checks = options;
  with_checks.before_build = [&](const VoxelFormat& format) -> Status {
    GVX_TRY(check_before_building(scene, format, options.naming));
    return options.before_build(format);
  };
  GVX_ASSIGN(OpenVolume volume, open_volume(scene, with_checks));
  return show(std::move(volume), scene, options);
}

Result<OpenScene> look_at(const OpenVolume& volume, const scene::SceneFile& scene,
                          const OpenOptions& options) {
  GVX_TRY(check_before_opening(scene, options));
  return show(volume, scene, options);
}

}  // namespace gvx::open
