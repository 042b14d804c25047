/// \file
/// RangeReader: ranges of bytes from wherever a store is. Files now; a server that answers HTTP ranges fits
/// behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "gvx/core/result.h"

namespace gvx::store {

/// Thread-safe.
class RangeReader {
 public:
  virtual ~RangeReader() = default;
  virtual std::uint64_t size_bytes() const = 0;
  /// Fills `out` from `offset` on; an error where the range is not all there.
  virtual Status read(std::uint64_t offset, std::span<std::byte> out) const = 0;
};

/// A regular file.
Result<std::unique_ptr<RangeReader>> open_file_ranges(const std::string& path);

}  // namespace gvx::store
