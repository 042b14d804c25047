/// \file
/// From the axes of an NRRD header to three dimensions and their place in the world.
#pragma once

#include <map>
#include <string>

#include "gvx/core/result.h"
#include "gvx/io/volume_file.h"

namespace gvx::io {

/// A header's fields by name, in small letters.
using NrrdFields = std::map<std::string, std::string>;

/// Fills dimensions, voxel_to_world and anatomical from the fields dimension, sizes, kinds, spacings, space,
/// space directions, space origin and space units; description.path must be set, for messages.
Status interpret_nrrd_axes(const NrrdFields& fields, VolumeDescription& description);

}  // namespace gvx::io
