/// \file
/// NRRD headers, attached and detached (teem's "Definition of NRRD File Format", versions 1 to 5).
#pragma once

#include <string>

#include "gvx/core/result.h"
#include "gvx/io/volume_file.h"

namespace gvx::io {

/// Reads the header of a .nrrd or .nhdr file. One scalar volume: 3 axes, 2 (one slice), or 4 of which one has
/// the length 1; a first axis of two to four numbers holds a voxel's components. The encodings hex and zrl
/// are errors. A known patient space becomes RAS+ millimetres. Where no space origin is stated, the corner of
/// voxel (0, 0, 0) is the world's origin.
Result<VolumeFile> parse_nrrd(const std::string& path);

}  // namespace gvx::io
