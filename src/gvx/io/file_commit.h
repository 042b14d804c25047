/// \file
/// Bytes that are there whole or not at all (core/partial_file.h says how).
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "gvx/core/partial_file.h"
#include "gvx/core/result.h"

namespace gvx::io {

/// Creates or replaces `path` with the bytes; on failure nothing has changed. A device, a pipe or what a
/// descriptor such as /dev/stdout stands for is written to.
Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes);

}  // namespace gvx::io
