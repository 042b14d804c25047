/// \file
/// Warnings of what a store does not hold as its volume file says.
#pragma once

#include <string>

#include "gvx/io/store_build.h"

namespace gvx::app {

/// Prints a line for each of them on standard error.
void warn_of_build(const std::string& path, const io::VolumeDescription& volume,
                   const io::StoreBuildReport& report);

}  // namespace gvx::app
