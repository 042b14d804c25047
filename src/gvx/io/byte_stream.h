/// \file
/// ByteStream: the decoded bytes of a file or pipe in order, whatever they were packed with. Memory is
/// bounded: the file's buffer and the decoder's state, never the data.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "gvx/core/result.h"
#include "gvx/io/file_source.h"
#include "gvx/io/sample_type.h"

namespace gvx::io {

/// How samples are written down: as they are, packed (gzip stands for zlib streams too), or as decimal text.
enum class Encoding { raw, gzip, bzip2, ascii };

/// Where in a file the encoded bytes begin.
struct StreamStart {
  std::int64_t file_offset = 0;  ///< Bytes of the file before the first line or code.
  std::int64_t line_skip = 0;    ///< Lines of the file, counted from file_offset, before the code begins.
};

/// Sequential decoded bytes; rewind() goes back to the first of them.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  /// Fills `out` unless the data end first; returns the number of bytes written.
  virtual Result<std::size_t> read(std::span<std::byte> out) = 0;

  /// Passes over `count` bytes; returns fewer only where the data end first.
  virtual Result<std::uint64_t> skip(std::uint64_t count);

  /// Decoded bytes from here to the end, where the file's size tells them: raw regular files.
  virtual std::optional<std::uint64_t> bytes_left() const { return std::nullopt; }

  /// Does read() within this time find bytes, or the end?
  bool comes_within(std::chrono::milliseconds time) const { return source_.comes_within(time); }

  /// Goes back to the first byte; an error for pipes.
  Status rewind();
  bool can_rewind() const { return source_.seekable(); }

  /// Bytes of the file, as it is on disk, that have been passed so far.
  std::uint64_t bytes_consumed() const { return source_.position(); }

  /// What messages call the file.
  const std::string& name() const { return source_.name(); }

 protected:
  /// Decoding starts at the source's position.
  explicit ByteStream(FileSource source);

  FileSource source_;

 private:
  virtual Status restart() = 0;

  std::uint64_t start_;
};

/// Opens `path` ("-" is standard input) at `start`. With Encoding::ascii the stream holds samples of `type`
/// in native byte order, and read() must ask for whole ones.
Result<std::unique_ptr<ByteStream>> open_byte_stream(const std::string& path, Encoding encoding,
                                                     const StreamStart& start, SampleType type);

}  // namespace gvx::io
