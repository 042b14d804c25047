/// \file
/// Presets: ready transfer functions by name, and the choice of one that suits a volume's values.
#pragma once

#include <span>
#include <string>

#include "gvx/core/result.h"
#include "gvx/scene/transfer_function.h"
#include "gvx/scene/value_statistics.h"

namespace gvx::scene {

/// The names that preset() knows.
std::span<const char* const> preset_names();

/// A ready transfer function by name. The CT presets are in Hounsfield units. The others fit the statistics:
/// "mr" and "surface" the border between background and object, "layers" the shares of voxels, "diverging"
/// the spread around zero, "microscopy" the brightest few per cent. "ramp" is for projections.
Result<TransferFunction> preset(const std::string& name, const ValueStatistics& statistics);

/// The name of the preset that suits these values: "ct-bone" for the Hounsfield range of a CT, "microscopy"
/// for several channels, "diverging" for values around zero, "mr" for other scans of patients. For all others
/// it depends on the histogram: "surface" if it shows background and object, "layers" if it does not, "gray"
/// if there is none.
std::string suggest_preset(const ValueStatistics& statistics);

}  // namespace gvx::scene
