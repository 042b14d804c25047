/// \file
/// What ImageJ writes into the description of a TIFF file's first page (lines of KEY=VALUE, as its class
/// FileInfo and TiffEncoder have them) and into the private tags 50838 and 50839.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gvx/core/vec.h"
#include "gvx/io/tiff_file.h"

namespace gvx::io {

struct ImageJInfo {
  std::int64_t images = 1, channels = 1, slices = 1, frames = 1;  ///< Channels fastest, frames slowest.
  std::array<std::optional<double>, 3> spacing;                   ///< Along x, y and z.
  Vec3d origin;                  ///< The pixel whose centre is the world's origin.
  std::string unit;              ///< As written, with micrometres as "µm".
  double scale = 1, offset = 0;  ///< Value = scale * sample + offset, where ImageJ's calibration is a line.
  std::vector<Vec3f> colors;     ///< The last colour of each channel's lookup table.
};

/// Nothing where the description is not ImageJ's.
std::optional<ImageJInfo> parse_imagej(const TiffTags& tags);

}  // namespace gvx::io
