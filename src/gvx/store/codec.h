/// \file
/// Compression of one block of bytes: bricks and index pages. Stateless and thread-safe.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/format.h"

namespace gvx::store {

/// What a block holds: `elements` numbers of `element_bytes` each, and after them single bytes.
struct BlockLayout {
  std::size_t element_bytes = 1;
  std::size_t elements = 0;
};

/// Replaces `compressed` by the compressed form of `raw`. Elements wider than a byte are split into planes of
/// equal significance before they are compressed.
void compress(Codec codec, BlockLayout layout, std::span<const std::byte> raw,
              std::vector<std::byte>& compressed);

/// Fills `raw`, whose size is known, from its compressed form; an error where the bytes are not of that form.
Status decompress(Codec codec, BlockLayout layout, std::span<const std::byte> compressed,
                  std::span<std::byte> raw);

}  // namespace gvx::store
