/// \file
/// Frames of DICOM files that are packed as JPEG, JPEG-LS or JPEG 2000 (by GDCM, where the build has it) or
/// with DICOM's run lengths.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/dicom_image.h"

namespace gvx::io {

/// What frames decode to: their samples are side by side, in native byte order, as `format` has them.
/// `code` is the whole code of one frame. Nothing is decoded before the code's own header has been compared
/// with the format. `path` is for messages.
Result<std::vector<std::byte>> decode_dicom_frame(const std::string& path, DicomPacking packing,
                                                  const std::string& transfer_syntax,
                                                  const DicomPixelFormat& format,
                                                  std::span<const std::byte> code);

/// Red, green and blue of luminance and colour differences of 8 bits: the inverse of YBR_FULL (PS3.3,
/// C.7.6.3.1.2).
std::array<std::uint8_t, 3> rgb_of_ybr(double y, double b, double r);

}  // namespace gvx::io
