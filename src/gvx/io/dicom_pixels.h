/// \file
/// DicomPixels: the pixels of one slice at a time, from any of many DICOM files. It holds one file open and
/// one stored frame in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/dicom_image.h"
#include "gvx/io/dicom_source.h"

namespace gvx::io {

class DicomPixels {
 public:
  /// Fills `out` with the samples of a slice in native byte order, of the format's type() and components():
  /// unused bits are cleared or hold the sign, colours are red, green and blue. An error where the file has
  /// changed since its header was read.
  Status read_slice(const DicomImage& image, const DicomFrame& frame, std::span<std::byte> out);

 private:
  struct Fragment {
    std::uint64_t offset = 0;
    std::uint32_t bytes = 0;
  };
  struct Palette {
    std::int64_t first = 0;  // pixel value of entry 0
    std::vector<std::uint8_t> entries[3];
  };

  Status open(const DicomImage& image);
  Status find_fragments(const DicomImage& image);
  Status share_fragments(const std::vector<Fragment>& fragments, const std::vector<std::uint32_t>& offsets,
                         std::uint64_t first_offset, std::size_t frames);
  Status read_frame(const DicomImage& image, std::int64_t number);
  Status read_bytes(std::uint64_t offset, std::span<std::byte> out);
  Status read_palette();
  void convert(const DicomImage& image, const DicomFrame& frame, std::span<std::byte> out) const;

  std::string open_path_;
  std::optional<DicomSource> source_;
  DicomHeader header_;
  std::vector<std::vector<Fragment>> codes_;  // of each frame of a packed file
  Palette palette_;
  std::int64_t frame_number_ = -1;  // of the frame in frame_
  std::vector<std::byte> frame_;    // as stored, in native byte order
  bool side_by_side_ = false;       // its samples, whatever the header says
};

}  // namespace gvx::io
