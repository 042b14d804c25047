/// \file
/// Bzip2Stream: a bzip2 file, decoded.
#pragma once

#include <memory>

#include <bzlib.h>

#include "gvx/io/byte_stream.h"

namespace gvx::io {

/// Checks the checksums and goes on through concatenated bzip2 streams.
class Bzip2Stream final : public ByteStream {
 public:
  static Result<std::unique_ptr<ByteStream>> create(FileSource source);

  Bzip2Stream(const Bzip2Stream&) = delete;
  Bzip2Stream& operator=(const Bzip2Stream&) = delete;
  ~Bzip2Stream() override;

  Result<std::size_t> read(std::span<std::byte> out) override;

 private:
  explicit Bzip2Stream(FileSource source) : ByteStream(std::move(source)) {}
  Status restart() override;
  Result<bool> next_member();

  bz_stream state_{};
  bool open_ = false;  // inside a member: state_ holds memory
  bool any_member_ = false;
};

}  // namespace gvx::io
