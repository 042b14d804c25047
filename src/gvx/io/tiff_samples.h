/// \file
/// Samples of TIFF pixels as they are stored, of any number of bits, into those that readers hand out.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gvx/io/tiff_page.h"

namespace gvx::io {

/// The samples of a row of pixels as libtiff decodes them: in native byte order; those whose bits are not
/// whole bytes one after the other from the highest bit on.
struct StoredRow {
  const std::byte* begin = nullptr;
  int bits = 8;
  bool floating = false;
  int samples = 1;  ///< A pixel, of those that are stored together.
};

/// Writes sample `sample` of `count` pixels as `type`, each `pixel_bytes` behind the one before it.
void unpack_samples(const StoredRow& row, int sample, std::int64_t count, SampleType type, std::byte* out,
                    std::size_t pixel_bytes);

/// Does a row of stored samples have the bytes that are handed out?
bool stored_as_handed_out(const TiffPage& page);

/// An IEEE 754 number of 16 bits.
float half_to_float(std::uint16_t half);

}  // namespace gvx::io
