/// \file
/// InflateStream: a gzip file, a zlib stream or bare deflated data, decoded.
#pragma once

#include <memory>

#include <zlib.h>

#include "gvx/io/byte_stream.h"

namespace gvx::io {

/// Tells gzip from zlib by the first bytes, checks the checksums, and goes on through concatenated gzip
/// members.
class InflateStream final : public ByteStream {
 public:
  static Result<std::unique_ptr<ByteStream>> create(FileSource source);

  /// Deflated data without a header or checksum (RFC 1951), from the source's position on.
  static Result<std::unique_ptr<ByteStream>> create_bare(FileSource source);

  InflateStream(const InflateStream&) = delete;
  InflateStream& operator=(const InflateStream&) = delete;
  ~InflateStream() override;

  Result<std::size_t> read(std::span<std::byte> out) override;

 private:
  InflateStream(FileSource source, bool bare) : ByteStream(std::move(source)), bare_(bare) {}
  static Result<std::unique_ptr<ByteStream>> start(FileSource source, bool bare);
  Status restart() override;
  Result<bool> next_member();

  z_stream state_{};
  bool bare_;
  bool between_members_ = true;  // before the first member, or after the end of one
  bool any_member_ = false;
};

}  // namespace gvx::io
