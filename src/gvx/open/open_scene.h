/// \file
/// open_scene: from a scene to a producer and a view, which an engine renders. The scene may come from a
/// file, a text, or flags.
///
///     GVX_ASSIGN(const auto scene, scene::parse_scene(R"({"volume": "head.gvx"})", "request"));
///     GVX_ASSIGN(const auto opened, open::open_scene(scene));
#pragma once

#include <optional>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/result.h"
#include "gvx/open/open_volume.h"
#include "gvx/open/options.h"
#include "gvx/render/frame/view.h"
#include "gvx/scene/camera_path.h"
#include "gvx/scene/scene_file.h"

namespace gvx::open {

/// An object of a scene, which can be rendered.
struct OpenObject {
  OpenVolume volume;  ///< its producer is shared by the objects that name the same volume in the same way
  render::View look;  ///< its ObjectLook counts, and what all objects have in common, but not the camera
  Affine3 to_world;   ///< from the world of the volume to that of the scene
};

/// A scene that can be rendered.
struct OpenScene {
  OpenVolume volume;                           ///< of the first object
  std::vector<OpenObject> objects;             ///< at least one
  scene::SceneFile scene;                      ///< with all that was left out chosen to suit the volume
  render::View view;                           ///< from the camera, or from the first key frame
  std::optional<scene::CameraPath> path = {};  ///< of the key frames, if there are any
};

/// Opens a scene's volume, after all that can be checked without it; chooses what the scene leaves out, and
/// makes the view. File names are as seen from the working folder: see resolve_names(). Errors begin with the
/// field or the file.
Result<OpenScene> open_scene(const scene::SceneFile& scene, const OpenOptions& options = {});

/// The same for a volume that is open: what the scene says of the volume itself is not read again. For
/// another camera or function of a volume that is shown alone.
Result<OpenScene> look_at(const OpenVolume& volume, const scene::SceneFile& scene,
                          const OpenOptions& options = {});

/// Does the scene have several objects, or one that is moved?
bool has_placed_objects(const scene::SceneFile& scene);

/// Opens all objects of a scene; one where it has no list of them. An error begins with the object.
Result<std::vector<OpenObject>> open_objects(const scene::SceneFile& scene, const OpenOptions& options = {});

}  // namespace gvx::open
