/// \file
/// The cameras of a scene: what can be said of them before its volume is there, and those that frame it.
#pragma once

#include <optional>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/open/open_volume.h"
#include "gvx/open/options.h"
#include "gvx/scene/camera_path.h"
#include "gvx/scene/scene_file.h"

namespace gvx::open {

/// What of the camera and its path can be told before a volume says what else is to be framed.
Status check_cameras(const scene::SceneFile& scene);

/// Chooses what the cameras of a scene leave out, so that what can be seen of the volume fills the picture.
/// All else of the scene is complete.
Status complete_cameras(scene::SceneFile& scene, const OpenVolume& volume, const FieldNaming& naming);

/// A box of another space, and where it is in the world.
struct PlacedBox {
  Box3d box;
  Affine3 to_world;
};
/// The same so that all boxes, of which there is at least one, fill the picture.
Status complete_cameras(scene::SceneFile& scene, const std::vector<PlacedBox>& boxes);

/// Of a complete scene; nothing where it has no key frames.
Result<std::optional<scene::CameraPath>> camera_path(const scene::SceneFile& scene);

}  // namespace gvx::open
