/// \file
/// TiffVolume: a volume that is spread over the pages of TIFF files, and which sample of which page each of
/// its planes is. A plane is one slice of one channel at one time.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/tiff_file.h"
#include "gvx/io/volume_file.h"
#include "gvx/io/volume_options.h"

namespace gvx::io {

struct TiffPlane {
  std::int64_t page = -1;  ///< Index into TiffVolume::pages; -1: no file has it, and it reads as 0.
  int sample = 0;          ///< Of the page's pixels.
};

struct TiffVolume {
  VolumeDescription description;
  std::vector<std::string> files;   ///< That are read, in the order of TiffPage::file.
  std::vector<std::string> others;  ///< Files that were read for their metadata.
  std::vector<TiffPage> pages;      ///< All of one shape.
  std::vector<TiffPlane> planes;    ///< Component c of slice z at z * components + c.
};

/// Finds the volume in a file, a folder or a pattern: an OME-TIFF, an ImageJ hyperstack, pages that are
/// slices, or files that are.
Result<TiffVolume> find_tiff_volume(const std::string& path, const VolumeOptions& options);

// What the kinds of files share:

/// The frame that the options ask for, or 0; sets frames, frame and a remark. An error where there are not
/// so many.
Result<std::int64_t> choose_frame(const VolumeOptions& options, std::int64_t frames, VolumeDescription& d);

/// Sets dimensions, type, components, colours and remarks for pages of this shape, where a slice takes
/// `channels` pages. Returns the samples of a page that are components. More than four components: the first
/// four are kept, and a remark says so. An error where gvx cannot read such pages.
Result<int> describe_samples(const TiffFile& file, const TiffPage& page, std::int64_t slices,
                             std::int64_t channels, VolumeDescription& d);

/// Fills the planes: page_of(slice, channel) is the index of a page or -1, and `samples` what
/// describe_samples() returned.
void set_planes(TiffVolume& volume, int samples,
                const std::function<std::int64_t(std::int64_t slice, std::int64_t channel)>& page_of);

/// Voxel (0, 0, 0)'s centre at the world's origin; axes that are not known have the spacing 1.
void set_place(const std::array<std::optional<double>, 3>& spacing, VolumeDescription& d);

/// An OME-TIFF, whose metadata `xml` holds, from the file `xml_path`. `file` is the one that was asked for,
/// and `pages` are its.
Result<TiffVolume> find_ome_volume(const std::string& path, const std::string& xml_path,
                                   const std::string& xml, const TiffFile& file,
                                   const std::vector<TiffPage>& pages, const VolumeOptions& options);

/// "a, b and 3 others".
std::string some_of(const std::vector<std::string>& names);

}  // namespace gvx::io
