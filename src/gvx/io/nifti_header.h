/// \file
/// The headers of NIfTI-1, NIfTI-2 and Analyze 7.5: their numbers, whatever the layout and byte order.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "gvx/core/result.h"
#include "gvx/io/byte_stream.h"

namespace gvx::io {

/// The fields that gvx asks for, named as in nifti1.h.
struct NiftiHeader {
  /// Which files there are: a header with its samples behind it, or a header and its samples in two files.
  enum class Kind { single, pair, analyze };

  int version = 1;  ///< 2 for NIfTI-2, whose counts have 64 bits and whose numbers are doubles
  Kind kind = Kind::analyze;
  bool big_endian = false;
  std::array<std::int64_t, 8> dim{};
  std::array<double, 8> pixdim{};
  int datatype = 0;
  double vox_offset = 0;
  int intent_code = 0;  ///< of what the numbers mean
  double scl_slope = 0, scl_inter = 0;
  int qform_code = 0, sform_code = 0;
  std::array<double, 3> quatern{};  ///< b, c, d
  std::array<double, 3> qoffset{};
  std::array<std::array<double, 4>, 3> srow{};
  int xyzt_units = 0;

  /// Where the samples of a single file begin at the earliest.
  int least_vox_offset() const { return version == 2 ? 544 : 352; }
};

/// Encoding::gzip where the file begins like one, else Encoding::raw.
Result<Encoding> detect_gzip(const std::string& path);

/// Reads the header, plain or gzip, and finds its byte order; other files are errors.
Result<NiftiHeader> read_nifti_header(const std::string& path);

}  // namespace gvx::io
