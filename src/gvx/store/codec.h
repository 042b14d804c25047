/// \file
/// Compression of one block of bytes: bricks and index pages. Stateless and thread-safe.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/format.h"

namespace gvx::store {

/// Appends the compressed form of `raw`, whose elements are `element_bytes` wide, to `compressed`, which is
/// cleared first. Elements wider than a byte are split into planes of equal significance before they are
/// compressed.
void compress(Codec codec, std::size_t element_bytes, std::span<const std::byte> raw,
              std::vector<std::byte>& compressed);

/// Fills `raw`, whose size is known, from its compressed form; an error where the bytes are not of that form.
Status decompress(Codec codec, std::size_t element_bytes, std::span<const std::byte> compressed,
                  std::span<std::byte> raw);

}  // namespace gvx::store
