/// \file
/// DicomPixelFormat: how a DICOM file stores its pixels.
#pragma once

#include <cstdint>

#include "gvx/core/result.h"
#include "gvx/io/dicom_elements.h"
#include "gvx/io/sample_type.h"

namespace gvx::io {

enum class DicomColor { gray, inverted_gray, palette, rgb, ybr, ybr_422 };

/// How a file stores a frame (PS3.5, section 8; PS3.3, C.7.6.3).
struct DicomPixelFormat {
  std::int64_t rows = 0, columns = 0;  ///< Of the stored frame; of a mosaic all its tiles together.
  int samples = 1;                     ///< A pixel: 1 or 3.
  bool planar = false;                 ///< One plane a sample instead of samples side by side.
  int bits_allocated = 8;              ///< 1, 8, 16, 32 or 64.
  int bits_stored = 8;
  int high_bit = 7;
  bool is_signed = false;
  bool floating = false;
  DicomColor color = DicomColor::gray;

  /// Of a frame that is not packed; for one bit a pixel rounded up.
  std::uint64_t frame_bytes() const;

  /// What readers hand out: u8 for colours.
  SampleType type() const;

  /// 3 for colours, also for those of a palette.
  int components() const { return color == DicomColor::gray || color == DicomColor::inverted_gray ? 1 : 3; }

  bool operator==(const DicomPixelFormat&) const = default;
};

/// An error where a field that the pixels need is absent or impossible.
Result<DicomPixelFormat> interpret_format(const DicomHeader& header);

/// NumberOfFrames, 1 where it is absent. An error where the file is too short for that many.
Result<std::int64_t> count_frames(const DicomHeader& header, const DicomPixelFormat& format);

/// The bytes of the pixel element behind its frames, without one that pads it; 0 for packed pixels.
std::uint64_t surplus_pixel_bytes(const DicomHeader& header, const DicomPixelFormat& format,
                                  std::int64_t frames);

}  // namespace gvx::io
