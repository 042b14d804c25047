/// \file
/// From a scene file and an open volume to what is rendered; and names of files as seen from other folders.
#pragma once

#include <string>

#include "gvx/core/result.h"
#include "gvx/render/frame/view.h"
#include "gvx/scene/scene_file.h"
#include "open_scene.h"
#include "scene_flags.h"

namespace gvx::app {

/// What is known of a raw file, as readers take it.
io::VolumeOptions volume_options(const scene::SceneFile& scene);

/// What can be said of a scene before its volume is opened: an error where a function is neither a file that
/// can be read nor a preset, where a camera is no view, or where flags do not go together.
Status check_before_opening(const scene::SceneFile& scene, const SceneFlags& flags);

/// And before a volume of these voxels is built: an error where they cannot be shown so.
Status check_before_building(const scene::SceneFile& scene, const SceneFlags& flags,
                             const VoxelFormat& format);

/// The scene with all that it and the flags leave out chosen to suit the volume, so that nothing is left out.
Result<scene::SceneFile> complete(scene::SceneFile scene, const SceneFlags& flags, const Scene& opened);

/// Of a complete scene.
Result<render::View> make_view(const scene::SceneFile& scene, const SceneFlags& flags, const Scene& opened);

/// Names of files, as seen from the scene file's folder, as seen from here.
void resolve_names(scene::SceneFile& scene, const std::string& scene_path);
/// And the way back, for a scene file that is to be written.
void relate_names(scene::SceneFile& scene, const std::string& scene_path);

}  // namespace gvx::app
