/// \file
/// The transfer functions and labels of a scene: what can be said of them before its volume is there, those
/// that suit it, and the functions themselves.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/open/open_volume.h"
#include "gvx/open/options.h"
#include "gvx/scene/scene_file.h"
#include "gvx/scene/transfer_function.h"

namespace gvx::open {

bool is_preset(const std::string& name);

/// An error where a function is neither a preset nor a file that can be read, or a table of labels cannot.
Status check_function_files(const scene::ObjectParts& scene, const OpenOptions& options);

/// Does a volume of these voxels take as many functions, windows of them, gradients, and labels?
Status check_functions(const scene::ObjectParts& scene, const VoxelFormat& format, const FieldNaming& naming);

/// One a channel; none for labels, whose colours are their own, unless the scene has one. The scene has a
/// mode.
Result<std::vector<scene::FunctionParts>> complete_functions(const scene::ObjectParts& scene,
                                                             const OpenVolume& volume,
                                                             const FieldNaming& naming);

/// Those of a complete scene.
Result<std::vector<scene::TransferFunction>> open_functions(const scene::ObjectParts& scene,
                                                            const OpenVolume& volume,
                                                            const FieldNaming& naming);

/// Where a function's points are so close, and the values so far apart, that what lies between is blurred.
void warn_of_close_points(const produce::TreeDescription& tree,
                          const std::vector<scene::TransferFunction>& functions, const Warn& warn);

/// What the labels of a scene's table are called and look like, as far as the volume may hold them: a list of
/// objects with label, name and color (#rrggbb). `function` is the one that shows them. Empty where there is
/// no table.
Result<nlohmann::json> label_legend(const scene::ObjectParts& scene, const scene::TransferFunction& function,
                                    const OpenVolume& volume);

}  // namespace gvx::open
