/// \file
/// DICOM: a file, or a folder (also with folders in it) of files with one or several series. Headers are read
/// when the volume is opened, pixels slice by slice.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/volume_options.h"
#include "gvx/io/volume_reader.h"

namespace gvx::io {

/// Is it a file that begins as DICOM does or is named .dcm, .dicom or .ima (also with .gz), or a folder with
/// one among the first 4096 files in it and in its folders?
bool is_dicom(const std::string& path);

/// Opens one frame of one series. Without `options.series` the series with most slices is taken, and a remark
/// names the others. Files of a folder that are no DICOM images are passed over, and counted in a remark.
Result<std::unique_ptr<SliceReader>> open_dicom(const std::string& path, const VolumeOptions& options);

/// The DICOM files of a folder, sorted, or the one file.
std::vector<std::string> dicom_files(const std::string& path);

}  // namespace gvx::io
