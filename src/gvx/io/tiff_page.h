/// \file
/// TiffPage: how the samples of one page (image file directory, IFD) of a TIFF file are stored.
#pragma once

#include <cstdint>
#include <string>

#include "gvx/io/sample_type.h"

namespace gvx::io {

/// Photometric interpretations (TIFF 6.0, section 8) that the reader tells apart.
enum class TiffColors { min_is_black, min_is_white, rgb, palette };

struct TiffPage {
  std::uint32_t file = 0;      ///< Index of its file among those of the volume.
  std::int64_t number = 1;     ///< In its file, from 1: what messages say.
  std::uint64_t position = 0;  ///< Of its directory in the file, in bytes.
  std::int64_t width = 0, height = 0;
  SampleType type = SampleType::u8;  ///< Of a sample as it is handed out.
  int bits = 8;                      ///< Of a sample in the file: 1 to 64.
  bool floating = false;             ///< IEEE numbers; those of 16 bits are handed out as f32.
  int samples = 1;                   ///< A pixel.
  int alpha_sample = -1;             ///< Which of them is an opacity, if one is.
  bool separate = false;             ///< The samples lie in planes of their own (PlanarConfiguration 2).
  bool reduced = false;              ///< A smaller copy of another page, or a mask (NewSubfileType).
  bool raw = false;  ///< The samples lie uncompressed in one run from `raw_position`, without a directory.
  std::uint64_t raw_position = 0;
  bool big_endian = false;  ///< Of the file.
  TiffColors colors = TiffColors::min_is_black;
  int orientation = 1;     ///< Tag 274; 1: the first row is the top, the first column is on the left.
  std::string unreadable;  ///< Why gvx cannot read its samples, or empty.
};

/// Are they pictures of one size whose pixels are stored alike? Compression and strips may differ.
bool same_shape(const TiffPage& a, const TiffPage& b);

/// Is `page` a copy of `full` with fewer pixels: both axes shorter by the same factor, from 1.5 on?
bool is_smaller_copy(const TiffPage& page, const TiffPage& full);

/// "48 x 33 pixels of u16", with the number of samples where there are several.
std::string shape_text(const TiffPage& page);

}  // namespace gvx::io
