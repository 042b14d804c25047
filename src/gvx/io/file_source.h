/// \file
/// FileSource: the bytes of a file or pipe in order, through one small buffer that decoders may look into.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"

namespace gvx::io {

/// Owns an open file; "-" is standard input. Memory stays at the buffer's 256 KiB whatever the file's size.
class FileSource {
 public:
  /// Fails where there is no such file, it may not be read, or it is a folder.
  static Result<FileSource> open(const std::string& path);

  FileSource(FileSource&& other) noexcept;
  FileSource& operator=(FileSource&&) = delete;
  ~FileSource();

  /// What messages call the file.
  const std::string& name() const { return name_; }

  /// The next bytes, at least `minimum` (at most 16) of them unless the file ends first; empty only at its
  /// end.
  Result<std::span<const std::byte>> peek(std::size_t minimum = 1);

  /// Moves past the first `count` bytes that peek() returned.
  void consume(std::size_t count);

  /// Fills `out` unless the file ends first; returns the number of bytes written.
  Result<std::size_t> read(std::span<std::byte> out);

  /// Does read() within this time find bytes, or the end? A pipe may keep one waiting.
  bool comes_within(std::chrono::milliseconds time) const;

  /// Goes to a byte of the file; an error for pipes.
  Status seek(std::uint64_t position);

  bool seekable() const { return seekable_; }

  /// Bytes from the beginning of the file to the next one.
  std::uint64_t position() const { return file_position_ - (end_ - begin_); }

  /// Bytes from here to the end of a regular file; nothing for pipes and devices.
  std::optional<std::uint64_t> bytes_left() const;

 private:
  FileSource(std::string name, int descriptor);
  Result<std::size_t> read_descriptor(std::span<std::byte> out);

  std::string name_;
  int descriptor_ = -1;
  bool seekable_ = false;
  std::optional<std::uint64_t> size_;
  std::uint64_t file_position_ = 0;  // of the descriptor: what is buffered lies before it
  std::vector<std::byte> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // the part of buffer_ not yet consumed
};

}  // namespace gvx::io
