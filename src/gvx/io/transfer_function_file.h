/// \file
/// Transfer functions in files: ParaView's JSON colour maps, and gvx's own, which are the same with a unit
/// distance.
#pragma once

#include <string>

#include "gvx/core/result.h"
#include "gvx/scene/transfer_function.h"

namespace gvx::io {

/// Reads the first colour map of a ParaView JSON file.
///
/// - "RGBPoints" are value, r, g, b, interpolated in "ColorSpace": RGB (the default), Lab, Diverging, HSV
///   ("HSVWrap": hues go the shorter way), or Step, where the second of two points counts between them.
/// - "IndexedColors" are r, g, b of categories, where there are no RGBPoints or "IndexedLookup" is set. Their
///   values are those of "Annotations" (value, name..), otherwise 0, 1, 2..
/// - "Points", if there, are value, opacity, midpoint, sharpness (the latter 0); otherwise opacity rises from
///   0 to 1 over the colours' values, and categories are as opaque as labels.
/// - "UnitDistance" is gvx's: world units that the opacities are of.
///
/// What else there is, such as "NanColor", says nothing of a volume.
Result<scene::TransferFunction> read_transfer_function(const std::string& path);

}  // namespace gvx::io
