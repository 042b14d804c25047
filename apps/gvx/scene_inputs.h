/// \file
/// The files that a command reads, by name: what an output must not be.
#pragma once

#include <string>
#include <vector>

#include "gvx/io/volume_options.h"
#include "gvx/scene/scene_file.h"

namespace gvx::app {

/// A volume or mesh file or a store, and every other file that it is spread over.
std::vector<std::string> files_of(const std::string& input, const io::VolumeOptions& options);

/// The scene file, if there is one, the files of the volume and of the functions that it names, and those of
/// --proxy. Names are as seen from here.
std::vector<std::string> files_of_scene(const std::string& scene_path, const scene::SceneFile& scene,
                                        const std::string& proxy);

}  // namespace gvx::app
