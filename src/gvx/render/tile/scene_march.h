/// \file
/// The march through scenes of several objects, on a CPU: for each tile of the film those objects that its
/// rays may meet.
#pragma once

#include "gvx/exec/device.h"
#include "gvx/render/march_pass.h"

namespace gvx::render {

/// As march_exact of march_pass.h, for several objects.
bool scene_march(const exec::Device& cpu, const ExactMarch& march);

/// As march_preview of march_pass.h, for several objects; a tile that was begun is drawn whole.
bool scene_preview(const exec::Device& cpu, const PreviewMarch& march);

}  // namespace gvx::render
