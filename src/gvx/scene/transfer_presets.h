/// \file
/// Transfer functions that are ready: by name, and the one that suits a volume's values.
#pragma once

#include <span>
#include <string>

#include "gvx/core/result.h"
#include "gvx/scene/transfer_function.h"
#include "gvx/scene/value_statistics.h"

namespace gvx::scene {

/// The names that preset() knows.
std::span<const char* const> preset_names();

/// A ready transfer function by name. The CT presets speak of Hounsfield units, the others fit themselves to
/// the statistics: "mr" and "surface" to the border between background and object, "layers" to the shares of
/// voxels, "diverging" to the spread around zero, "microscopy" to the brightest few per cent; "ramp" is for
/// projections.
Result<TransferFunction> preset(const std::string& name, const ValueStatistics& statistics);

/// The preset that suits values like these: "ct-bone" for a CT by its Hounsfield range, "microscopy" for
/// several channels, "diverging" for values around zero, "mr" for other scans of patients, "surface" where
/// the histogram falls into background and object, "layers" where it does not, and "gray" where there is
/// none.
std::string suggest_preset(const ValueStatistics& statistics);

}  // namespace gvx::scene
