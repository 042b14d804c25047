/// \file
/// DicomSource: the bytes of a DICOM file by their offset, also where the file is packed (.dcm.gz) or its
/// data set is deflated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "gvx/core/result.h"
#include "gvx/io/byte_stream.h"

namespace gvx::io {

/// Reading forward is cheap. Going back in packed data decodes them again from their beginning.
class DicomSource {
 public:
  /// A gzip file is unpacked on the fly.
  static Result<DicomSource> open(const std::string& path);

  /// From now on offset 0 is what deflated data at `offset` decode to. Not for gzip files.
  Status inflate_from(std::uint64_t offset);

  /// Fills `out` with the bytes from `offset` on, unless they end first; returns how many there were.
  Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> out);

  /// Where the bytes end; nothing for packed ones.
  std::optional<std::uint64_t> size() const { return size_; }

  const std::string& name() const { return name_; }

 private:
  DicomSource(std::string name, std::unique_ptr<ByteStream> stream);

  std::string name_;
  std::unique_ptr<ByteStream> stream_;
  std::uint64_t at_ = 0;  // the offset of the stream's next byte
  std::optional<std::uint64_t> size_;
};

}  // namespace gvx::io
