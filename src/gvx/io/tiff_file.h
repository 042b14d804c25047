/// \file
/// TiffFile: one TIFF or BigTIFF file, read by libtiff: the list of its pages, and the samples of one. What
/// libtiff complains about becomes the text of an Error; nothing is printed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/file_source.h"
#include "gvx/io/tiff_page.h"

using TIFF = struct tiff;

namespace gvx::io {

/// What the first page says beside its samples.
struct TiffTags {
  std::string description;                          ///< ImageDescription.
  std::array<std::optional<double>, 2> resolution;  ///< Pixels a unit along x and y.
  int resolution_unit = 2;                          ///< Of it: 1 none, 2 inch, 3 centimetre.
  std::vector<std::uint32_t> imagej_counts;         ///< Tag 50838: the bytes of each part of tag 50839.
  std::vector<std::byte> imagej_metadata;           ///< Tag 50839.
};

/// Where the samples of a page go: pixel (x, y) at begin + (y * width + x) * pixel_bytes.
struct TiffTarget {
  std::byte* begin = nullptr;
  std::size_t pixel_bytes = 0;
};

class TiffFile {
 public:
  /// Reads no more than the file's header. An error where the file is no TIFF or cannot be opened.
  static Result<std::unique_ptr<TiffFile>> open(const std::string& path);
  ~TiffFile();
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;

  const std::string& path() const { return path_; }
  std::uint64_t size_bytes() const { return size_bytes_; }

  /// All pages in the order of the file, without those that are levels of another (SubIFDs). An error where
  /// there are none, the list is broken or a loop, or the samples of a page that has some do not lie within
  /// the file.
  Result<std::vector<TiffPage>> pages();

  /// Of the first page; after pages().
  const TiffTags& tags() const { return tags_; }

  /// An error of that page.
  Error error(const TiffPage& page, const std::string& message) const;

  /// Writes samples `first` to `first + count - 1` of each pixel, side by side, in native byte order.
  /// `page` is one of pages().
  Status read(const TiffPage& page, int first, int count, const TiffTarget& target);

 private:
  explicit TiffFile(std::string path) : path_(std::move(path)) {}
  Error complaint(const TiffPage& page, const std::string& message) const;
  Result<TiffPage> describe_page(std::int64_t number);
  Status check_blocks(const TiffPage& page) const;
  /// Does the file hold all of the directory at this position, in bytes?
  Result<bool> is_whole_directory(std::uint64_t position) const;
  void read_tags();
  Status select(const TiffPage& page);
  Status read_strips(const TiffPage& page, int first, int count, const TiffTarget& target);
  Status read_tiles(const TiffPage& page, int first, int count, const TiffTarget& target);
  Status read_block(const TiffPage& page, std::uint32_t block, std::span<std::byte> out);
  Status read_raw(const TiffPage& page, int first, int count, const TiffTarget& target);

  std::string path_;
  std::uint64_t size_bytes_ = 0;
  std::int64_t page_count_ = 0;  // 0: not known
  TIFF* tiff_ = nullptr;
  std::unique_ptr<std::string> complaint_;  // the first thing that libtiff said of a call
  TiffTags tags_;
  std::vector<std::byte> block_;     // a strip or tile that was decoded
  std::optional<FileSource> bytes_;  // of the file, for pages without a directory
};

}  // namespace gvx::io
