/// \file
/// NIfTI-1 and NIfTI-2 headers (nifti1.h and nifti2.h of the NIfTI data format working group), single files
/// and pairs, and the Analyze 7.5 headers that they grew out of.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/io/volume_file.h"

namespace gvx::io {

/// Reads the header of .nii, .hdr or the .hdr beside an .img, plain or gzip (told by their first bytes).
/// Scalars or colours; of several points in time (dim[4]) the one of index `time`, or the first; vectors of
/// up to four numbers (dim[5]) are components. Complex numbers and further dimensions are errors. Counts in
/// dim below 1 are taken for 1, but for the first axis. World is RAS+ millimetres by the sform, else by the
/// qform; where there is neither, the corner of voxel (0, 0, 0) is the world's origin and pixdim the spacing.
Result<VolumeFile> parse_nifti(const std::string& path, std::optional<std::int64_t> time = std::nullopt);

}  // namespace gvx::io
