/// \file
/// TextScanner: bytes, lines and words of a file in order, whatever its lines end in: LF, CR LF, or CR alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/byte_stream.h"

namespace gvx::io {

/// Reads a text, or a binary file with a text before it, from front to back.
class TextScanner {
 public:
  /// Begins where the stream is.
  explicit TextScanner(std::unique_ptr<ByteStream> stream);

  /// "FILE: MESSAGE".
  Error error(const std::string& message) const;

  /// The next byte, which stays the next; nothing at the end.
  Result<std::optional<char>> peek();

  /// Fills `out`; an error where the file ends first.
  Status read(std::span<std::byte> out);

  /// The next line without its end; false where there is none. An error where it is longer than `most` bytes.
  Result<bool> line(std::string& text, std::size_t most);

  /// The bytes up to the first of `ends`, which is taken too and returned; nothing where the file ended.
  Result<std::optional<char>> line_until(std::string_view ends, std::string& text, std::size_t most);

  /// The next word between white space; empty at the end. An error where it is longer than `most` bytes. It
  /// holds until the next call.
  Result<std::string_view> word(std::size_t most);

  /// The next word as a number; an error where it is none, or the file ends.
  Result<double> number();

  /// Bytes from here to the file's end, where its size is known.
  std::optional<std::uint64_t> bytes_left() const;

  /// Bytes of the file that were read so far, as it is on disk.
  std::uint64_t bytes_consumed() const { return stream_->bytes_consumed(); }

 private:
  /// Makes sure that there is a next byte; false at the end.
  Result<bool> fill();

  std::unique_ptr<ByteStream> stream_;
  std::vector<std::byte> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // what of buffer_ is yet to be taken
  std::string word_;
};

}  // namespace gvx::io
