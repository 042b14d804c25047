/// \file
/// Warnings of what a store does not hold as its volume file says.
#pragma once

#include <string>

#include "gvx/io/store_build.h"
#include "gvx/open/options.h"

namespace gvx::open {

/// Warns with a line for each of them.
void warn_of_build(const std::string& path, const io::VolumeDescription& volume,
                   const io::StoreBuildReport& report, const Warn& warn);

}  // namespace gvx::open
