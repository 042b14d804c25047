/// \file
/// Pictures in files: 8-bit PNG, and EXR with 32-bit floats. A file is there whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"

namespace gvx::io {

/// Rows from top to bottom, four bytes a pixel: red, green, blue (sRGB) and alpha, not premultiplied.
struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgba;
};

/// Writes width*height pixels laid out as in Image; `rgba` holds exactly four bytes each. Pictures have 1 to
/// 2^28 pixels.
Status write_png(const std::string& path, std::uint32_t width, std::uint32_t height,
                 std::span<const std::uint8_t> rgba);

/// Reads a PNG of any kind as 8-bit RGBA; one of more than 2^28 pixels is an error.
Result<Image> read_png(const std::string& path);

/// Writes width*height pixels from the top row down as channels R, G, B and A of 32-bit floats, as they are,
/// ZIP compressed. In a build without OpenEXR an error that says so.
Status write_exr(const std::string& path, std::uint32_t width, std::uint32_t height,
                 std::span<const float> rgba);

/// Was this gvx built with OpenEXR?
bool can_write_exr();

/// Fails unless there are 1 to 2^28 pixels and `samples` is four times their number.
Status check_image_size(const std::string& path, std::uint32_t width, std::uint32_t height,
                        std::size_t samples);

}  // namespace gvx::io
