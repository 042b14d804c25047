/// \file
/// The transfer functions and labels of a scene: what can be said of them before its volume is there, those
/// that suit it, and the functions themselves.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "function_flags.h"
#include "gvx/core/result.h"
#include "gvx/render/frame/view.h"
#include "gvx/scene/scene_file.h"
#include "gvx/scene/transfer_function.h"
#include "open_scene.h"

namespace gvx::app {

bool is_preset(const std::string& name);

/// An error where a function is neither a preset nor a file that can be read, or a table of labels cannot.
Status check_function_files(const scene::SceneFile& scene, const FunctionFlags& flags);

/// Does a volume of these voxels take as many functions, windows of them, gradients, and labels?
Status check_functions(const scene::SceneFile& scene, const FunctionFlags& flags, const VoxelFormat& format);

/// One a channel; none for labels, whose colours are their own, unless the scene has one. The scene has a
/// mode.
Result<std::vector<scene::FunctionParts>> complete_functions(const scene::SceneFile& scene,
                                                             const FunctionFlags& flags, const Scene& opened);

/// Those of a complete scene.
Result<std::vector<scene::TransferFunction>> open_functions(const scene::SceneFile& scene,
                                                            const FunctionFlags& flags, const Scene& opened);

/// What the labels of a scene's table are called and look like, as far as the volume may hold them: a list of
/// objects with label, name and color (#rrggbb). Empty where there is no table.
Result<nlohmann::json> label_legend(const scene::SceneFile& scene, const render::View& view,
                                    const Scene& opened);

}  // namespace gvx::app
