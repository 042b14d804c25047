/// \file
/// The 348 bytes of a NIfTI-1 or Analyze 7.5 header, and the numbers in them in either byte order.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "gvx/core/result.h"
#include "gvx/io/byte_stream.h"

namespace gvx::io {

inline constexpr std::size_t kNiftiHeaderBytes = 348;

/// The header's bytes; numbers are named by their byte offsets in nifti1.h.
class NiftiHeader {
 public:
  std::array<std::byte, kNiftiHeaderBytes> bytes{};
  bool big_endian = false;

  template <typename T>
  T get(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> ordered;
    const bool swap = big_endian != (std::endian::native == std::endian::big);
    for (std::size_t i = 0; i < sizeof(T); ++i) ordered[i] = bytes[offset + (swap ? sizeof(T) - 1 - i : i)];
    return std::bit_cast<T>(ordered);
  }
  int short_at(std::size_t offset) const { return get<std::int16_t>(offset); }
  double float_at(std::size_t offset) const { return double{get<float>(offset)}; }

  int dim(int i) const { return short_at(40 + 2 * static_cast<std::size_t>(i)); }
  double pixdim(int i) const { return float_at(76 + 4 * static_cast<std::size_t>(i)); }
  bool has_magic(const char* magic) const { return std::memcmp(bytes.data() + 344, magic, 4) == 0; }
};

/// Encoding::gzip where the file begins like one, else Encoding::raw.
Result<Encoding> detect_gzip(const std::string& path);

/// Reads the header, plain or gzip, and finds its byte order; NIfTI-2 and other files are errors.
Result<NiftiHeader> read_nifti_header(const std::string& path);

}  // namespace gvx::io
