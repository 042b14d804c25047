/// \file
/// Private to this room: what all readers of slices check.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gvx/io/volume_reader.h"

namespace gvx::io {

/// An error unless so many slices are left of the reader, and `out` has their size.
Status check_read(const SliceReader& reader, std::int64_t count, std::span<const std::byte> out);

}  // namespace gvx::io
