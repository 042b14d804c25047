/// \file
/// read_text_file: a whole file of text, if it is not larger than it may be.
#pragma once

#include <cstddef>
#include <string>

#include "gvx/core/result.h"

namespace gvx {

/// No text file that gvx reads whole may be larger.
inline constexpr std::size_t kLargestTextFile = std::size_t{16} << 20;

/// All bytes of a file. An error if it cannot be read, or is larger than kLargestTextFile; `what` says what
/// it should be, such as "a scene file".
Result<std::string> read_text_file(const std::string& path, const char* what);

}  // namespace gvx
