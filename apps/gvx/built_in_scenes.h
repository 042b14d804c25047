/// \file
/// Scenes that are made, not loaded: `sponge`, `cloud`, `terrain`, and what is made of a mesh, NAME:MESH.
#pragma once

#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "open_scene.h"

namespace gvx::app {

/// Nothing where `name` is not that of a built-in scene.
Result<std::optional<Scene>> open_built_in_scene(const std::string& name);

}  // namespace gvx::app
