/// \file
/// StoreFile: the bytes of a store that is read. Counts and times what is read, and begins its errors with
/// the file's name.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/time_sum.h"
#include "gvx/store/range_reader.h"

namespace gvx::store {

/// Thread-safe.
class StoreFile {
 public:
  StoreFile(std::string path, std::unique_ptr<RangeReader> ranges)
      : path_(std::move(path)), ranges_(std::move(ranges)) {}

  const std::string& path() const { return path_; }
  std::uint64_t size_bytes() const { return ranges_->size_bytes(); }
  /// Is such a range within the file?
  bool has(std::uint64_t offset, std::uint64_t bytes) const {
    return offset <= size_bytes() && bytes <= size_bytes() - offset;
  }

  /// Fills `out` with the bytes from `offset` on.
  Status read(std::uint64_t offset, std::span<std::byte> out) const;
  /// The checksum of a range of any length; reads it piece by piece.
  Result<std::uint64_t> checksum_of(std::uint64_t offset, std::uint64_t bytes) const;

  /// "PATH: corrupt: WHAT".
  Error corrupt(const std::string& what) const { return {path_ + ": corrupt: " + what}; }

  /// Everything that was read so far, and how long that took, of all threads together.
  std::uint64_t bytes_read() const { return bytes_read_.load(std::memory_order_relaxed); }
  double reading_milliseconds() const { return reading_.milliseconds(); }
  /// Time that checking and decompressing took; those who do it add to it.
  TimeSum& decoding() const { return decoding_; }

 private:
  std::string path_;
  std::unique_ptr<RangeReader> ranges_;
  mutable std::atomic<std::uint64_t> bytes_read_{0};
  mutable TimeSum reading_, decoding_;
};

}  // namespace gvx::store
