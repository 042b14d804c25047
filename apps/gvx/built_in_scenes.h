/// \file
/// Scenes that are made, not loaded: `sponge`, `cloud`, `terrain`, and what is made of a mesh, NAME:MESH.
#pragma once

#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/scene/scene_file.h"
#include "open_scene.h"

namespace gvx::app {

/// Where in what is typed as SCENE the name of a file begins: behind "repeat:8:", "distance:" and the like.
std::size_t file_position(const std::string& scene);

/// Nothing where `name` is not that of a built-in scene. What the scene takes of `parts` is taken out of
/// them.
Result<std::optional<Scene>> open_built_in_scene(const exec::Device& device, const std::string& name,
                                                 scene::GenerateParts& parts);

}  // namespace gvx::app
