/// \file
/// The data elements of a DICOM file up to its pixels (DICOM PS3.5, sections 7 and A; PS3.10, section 7):
/// only those that gvx uses are kept. Files come from strangers: every length is checked against what the
/// file holds, nesting is bounded, and nothing is larger in memory than in the file.
///
///     128 bytes | "DICM" | (0002,xxxx): the file meta information | data set ... | pixel data
///     sometimes absent ^   explicit little-endian                   as its transfer syntax says
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "gvx/core/result.h"
#include "gvx/io/dicom_dataset.h"
#include "gvx/io/dicom_source.h"

namespace gvx::io {

/// How a file's pixels are packed.
enum class DicomPacking { native, rle, jpeg, jpeg_ls, jpeg_2000 };

/// A file up to its pixels.
struct DicomHeader {
  std::string path;
  DicomDataset elements;        ///< Also those of the file meta information.
  std::string transfer_syntax;  ///< Its UID; empty where the file has no file meta information.
  DicomPacking packing = DicomPacking::native;
  bool big_endian = false;  ///< The pixels.
  std::uint64_t deflated_from =
      0;                   ///< Where the deflated data set begins in the file; 0 where it is not deflated.
  DicomTag pixel_tag = 0;  ///< kPixelData or one of its kind; 0 where the file has none.
  std::uint64_t pixel_offset = 0;            ///< Of the first byte behind the pixel element's length.
  std::optional<std::uint64_t> pixel_bytes;  ///< Nothing where fragments follow.
};

inline constexpr DicomTag kPixelData = 0x7FE00010, kFloatPixelData = 0x7FE00008,
                          kDoublePixelData = 0x7FE00009;

/// Does a file begin as DICOM files do? Files without "DICM" are known by the elements of group 2 or 8 that
/// they begin with.
bool begins_as_dicom(std::string_view first_bytes);

/// Bytes that begins_as_dicom() wants to see.
inline constexpr std::size_t kDicomStartBytes = 144;

/// Reads the header. `source` is left so that pixel_offset is an offset in it.
Result<DicomHeader> read_dicom_header(DicomSource& source);

}  // namespace gvx::io
