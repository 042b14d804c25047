/// \file
/// MetaImage headers, .mha and .mhd (Kitware's MetaIO documentation).
#pragma once

#include <string>

#include "gvx/core/result.h"
#include "gvx/io/volume_file.h"

namespace gvx::io {

/// Reads the header of a .mha or .mhd file. One volume of one to four channels, in one file or in several
/// that are listed or follow a pattern. World is RAS+ (from LPS, as ITK understands it) when the file states
/// an orientation or an offset; otherwise only the spacing is used and the corner of voxel (0, 0, 0) is the
/// world's origin.
Result<VolumeFile> parse_metaimage(const std::string& path);

}  // namespace gvx::io
