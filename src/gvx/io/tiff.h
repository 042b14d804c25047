/// \file
/// Volumes in TIFF files: TIFF 6.0 and BigTIFF with pages as slices, OME-TIFF, ImageJ hyperstacks, and files
/// of one slice each in a folder or under a pattern. Read slice by slice; beside the slices only a strip or
/// a tile, and what is known of each page, is held.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/volume_options.h"
#include "gvx/io/volume_reader.h"

namespace gvx::io {

/// A file that begins as TIFF or BigTIFF, or is called .tif, .tiff, .btf, .tf2 or .tf8; a folder with such
/// names in it; or a pattern such as "z*.tif" or "z%04d.tif" that is not the name of a file.
bool is_tiff(const std::string& path);

/// Opens the volume; the world is in the file's own unit of length, x to the right, y down the rows, z from
/// slice to slice, with voxel (0, 0, 0)'s centre at the origin. Where the file does not say otherwise a voxel
/// is a unit cube. Fails where libtiff was not there when gvx was built.
Result<std::unique_ptr<SliceReader>> open_tiff(const std::string& path, const VolumeOptions& options);

/// All files that open_tiff() reads; `path` alone where it cannot be opened.
std::vector<std::string> tiff_files(const std::string& path, const VolumeOptions& options);

}  // namespace gvx::io
