/// \file
/// Which instruction sets this build's vectors are compiled for (CMake's GVX_VECTORS says which).
#pragma once

#include <cstdint>

#include "gvx/core/result.h"

namespace gvx::render {

/// The name of the instruction set whose vectors run: "AVX3" (AVX-512), "AVX2", "SSE4", "NEON"..
const char* instruction_set();

/// Bits of Highway's targets: all that there are vectors for, and the one that any processor must have.
extern const std::int64_t kInstructionSets;
extern const std::int64_t kLeastInstructionSet;

/// An error where this processor lacks what the vectors need at least: nothing may be rendered then.
Status check_processor();

}  // namespace gvx::render
