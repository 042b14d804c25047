/// \file
/// Transfer functions in files: ParaView's JSON colour maps, and gvx's own, which are the same with a unit
/// distance.
#pragma once

#include <string>

#include "gvx/core/result.h"
#include "gvx/scene/transfer_function.h"

namespace gvx::io {

/// Reads the first colour map of a ParaView JSON file. "RGBPoints" are value, r, g, b; "Points", if there,
/// are value, opacity, midpoint, sharpness (the latter 0), otherwise opacity rises from 0 to 1 over the
/// colours' values; colours are interpolated in "ColorSpace" RGB (the default) or Lab. "UnitDistance" is
/// gvx's: world units the opacities are of.
Result<scene::TransferFunction> read_transfer_function(const std::string& path);

}  // namespace gvx::io
