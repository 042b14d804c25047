/// \file
/// For tests: small TIFF files, written by libtiff.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tiffio.h>

#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {

/// One page of samples that lie in native byte order, x fastest, the samples of a pixel side by side.
struct TestPage {
  std::uint32_t width = 4, height = 3;
  SampleType type = SampleType::u8;
  int samples = 1;
  std::string bytes = {};
  std::string description = {};
  /// Sets further fields before the samples are written.
  std::function<void(TIFF*)> more = {};
};

inline int sample_format(SampleType type) {
  switch (type) {
    case SampleType::u8:
    case SampleType::u16:
    case SampleType::u32:
    case SampleType::u64:
      return SAMPLEFORMAT_UINT;
    case SampleType::f32:
    case SampleType::f64:
      return SAMPLEFORMAT_IEEEFP;
    default:
      return SAMPLEFORMAT_INT;
  }
}

/// Writes strips of two rows, or tiles where `more` set their size. `mode` as TIFFOpen() takes it: w, wb
/// (big-endian), w8 (BigTIFF).
inline void write_tiff(const std::string& path, const std::vector<TestPage>& pages, const char* mode = "w") {
  TIFF* tiff = TIFFOpen(path.c_str(), mode);
  ASSERT_NE(tiff, nullptr);
  for (const TestPage& page : pages) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, page.width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, page.height);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, page.samples);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sample_bytes(page.type)));
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, sample_format(page.type));
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 2);
    if (!page.description.empty()) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, page.description.c_str());
    if (page.more) page.more(tiff);
    std::string bytes = page.bytes;
    std::uint16_t planar = PLANARCONFIG_CONTIG;
    TIFFGetField(tiff, TIFFTAG_PLANARCONFIG, &planar);
    if (TIFFIsTiled(tiff) != 0) {
      // One tile that holds the page.
      std::uint32_t tile_width = 0;
      TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
      const std::size_t row = bytes.size() / page.height, tile_row = row / page.width * tile_width;
      std::string tile(static_cast<std::size_t>(TIFFTileSize(tiff)), '\7');
      for (std::size_t y = 0; y < page.height; ++y) bytes.copy(tile.data() + y * tile_row, row, y * row);
      ASSERT_GT(TIFFWriteEncodedTile(tiff, 0, tile.data(), static_cast<tmsize_t>(tile.size())), 0);
    } else {
      const auto strip = static_cast<std::size_t>(TIFFStripSize(tiff));
      std::uint32_t index = 0;
      const std::size_t planes = planar == PLANARCONFIG_SEPARATE ? static_cast<std::size_t>(page.samples) : 1;
      for (std::size_t plane = 0; plane < planes; ++plane) {
        const std::size_t size = bytes.size() / planes;
        for (std::size_t at = 0; at < size; at += strip) {
          ASSERT_GT(TIFFWriteEncodedStrip(tiff, index++, bytes.data() + plane * size + at,
                                          static_cast<tmsize_t>(std::min(strip, size - at))),
                    0);
        }
      }
    }
    ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
  }
  TIFFClose(tiff);
}

/// The small volume, a page a slice.
inline std::vector<TestPage> small_pages(SampleType type, const std::function<void(TIFF*)>& more = {}) {
  const std::string samples = native_small_samples(type);
  const std::size_t half = samples.size() / 2;
  return {TestPage{.type = type, .bytes = samples.substr(0, half), .more = more},
          TestPage{.type = type, .bytes = samples.substr(half), .more = more}};
}

/// Pages of one value each, of 4 x 3 u8.
inline std::vector<TestPage> flat_pages(const std::string& values, const std::string& description = {}) {
  std::vector<TestPage> pages;
  for (const char value : values) pages.push_back({.bytes = std::string(12, value)});
  if (!pages.empty()) pages.front().description = description;
  return pages;
}

/// The first sample of each slice.
inline std::string first_samples(const std::string& path, const VolumeOptions& options = {}) {
  const auto samples = load(path, options);
  if (!samples.ok()) return samples.error().message;
  const std::size_t slice = slice_bytes(describe(path, options).value());
  std::string values;
  for (std::size_t at = 0; at < samples.value().size(); at += slice) values += samples.value()[at];
  return values;
}

/// All remarks in one string.
inline std::string remarks_of(const std::string& path, const VolumeOptions& options = {}) {
  const auto d = describe(path, options);
  if (!d.ok()) return d.error().message;
  std::string text;
  for (const std::string& remark : d.value().remarks) text += remark + "\n";
  return text;
}

inline void expect_text(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << text << "\" does not say \"" << part << "\"";
}

}  // namespace gvx::io::test
