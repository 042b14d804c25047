/// \file
/// Scenes that are made, not loaded: `sponge`, `cloud`, `terrain`, and what is made of a mesh, NAME:MESH.
#pragma once

#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/open/open_volume.h"
#include "gvx/scene/scene_file.h"

namespace gvx::open {

/// Nothing where `name` is not that of a made scene. What the scene takes of `parts` is taken out of them.
/// `device` runs the kernels.
Result<std::optional<OpenVolume>> open_made_scene(const exec::Device& device, const std::string& name,
                                                  scene::GenerateParts& parts);

}  // namespace gvx::open
