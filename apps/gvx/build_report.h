/// \file
/// What became of a volume file in a store that is worth a warning.
#pragma once

#include <string>

#include "gvx/io/store_build.h"

namespace gvx::app {

/// Says on standard error what of the volume was not stored as it is: a line each.
void warn_of_build(const std::string& path, const io::VolumeDescription& volume,
                   const io::StoreBuildReport& report);

}  // namespace gvx::app
