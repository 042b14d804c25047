/// \file
/// The files that a scene names: which they are, and their names as seen from other folders.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "gvx/io/volume_options.h"
#include "gvx/scene/scene_file.h"

namespace gvx::open {

/// Where in the name of a volume that of a file begins: behind "repeat:8:", "distance:" and the like.
std::size_t file_position(const std::string& volume);

/// A volume or mesh file or a store, and every other file that it is spread over.
std::vector<std::string> files_of(const std::string& input, const io::VolumeOptions& options);

/// The files of the volume, of the functions and of the labels that a scene names, as seen from here.
std::vector<std::string> files_of_scene(const scene::SceneFile& scene);

/// Names of files, as seen from the scene file's folder, as seen from here.
void resolve_names(scene::SceneFile& scene, const std::string& scene_path);
/// And the way back, for a scene file that is to be written.
void relate_names(scene::SceneFile& scene, const std::string& scene_path);

}  // namespace gvx::open
