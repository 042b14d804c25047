// The samples of a page: its strips or tiles, decoded by libtiff one after the other.

#include <algorithm>
#include <bit>
#include <cstring>

#include <tiffio.h>

#include "gvx/io/tiff_field.h"
#include "gvx/io/tiff_file.h"
#include "gvx/io/tiff_samples.h"

namespace gvx::io {
namespace {

// A tile, or a strip that is not decoded right into the caller's memory.
constexpr std::uint64_t kMostBlockBytes = std::uint64_t{1} << 31;

}  // namespace

Status TiffFile::read(const TiffPage& page, int first, int count, const TiffTarget& target) {
  if (page.raw) return read_raw(page, first, count, target);
  GVX_TRY(select(page));
  return TIFFIsTiled(tiff_) != 0 ? read_tiles(page, first, count, target)
                                 : read_strips(page, first, count, target);
}

Status TiffFile::read_block(const TiffPage& page, std::uint32_t block, std::span<std::byte> out) {
  const bool tiled = TIFFIsTiled(tiff_) != 0;
  if (TIFFGetStrileOffset(tiff_, block) == 0 && TIFFGetStrileByteCount(tiff_, block) == 0) {
    std::fill(out.begin(), out.end(), std::byte{0});
    return {};
  }
  const auto bytes = static_cast<tmsize_t>(out.size());
  const tmsize_t read = tiled ? TIFFReadEncodedTile(tiff_, block, out.data(), bytes)
                              : TIFFReadEncodedStrip(tiff_, block, out.data(), bytes);
  if (read == bytes) return {};
  return complaint(page, (tiled ? "tile " : "strip ") + std::to_string(block + 1) + " cannot be decoded");
}

Status TiffFile::read_strips(const TiffPage& page, int first, int count, const TiffTarget& target) {
  const auto width = static_cast<std::size_t>(page.width);
  const std::int64_t rows =
      std::min<std::int64_t>(tiff_field<std::uint32_t>(tiff_, TIFFTAG_ROWSPERSTRIP, UINT32_MAX), page.height);
  const std::int64_t strips = (page.height + rows - 1) / rows;
  const int together = page.separate ? 1 : page.samples;
  const std::size_t bytes = sample_bytes(page.type), out_row = width * target.pixel_bytes;
  const bool direct = stored_as_handed_out(page) && count == together &&
                      target.pixel_bytes == static_cast<std::size_t>(count) * bytes;
  const auto row_bytes = static_cast<std::size_t>(TIFFVStripSize64(tiff_, 1));
  for (int plane = 0; plane < (page.separate ? count : 1); ++plane) {
    for (std::int64_t strip = 0; strip < strips; ++strip) {
      const auto in_strip = static_cast<std::size_t>(std::min(rows, page.height - strip * rows));
      const auto block = static_cast<std::uint32_t>(strip + (page.separate ? (first + plane) * strips : 0));
      std::byte* out = target.begin + static_cast<std::size_t>(strip * rows) * out_row;
      const std::size_t block_bytes = in_strip * row_bytes;
      if (direct && row_bytes == out_row) {
        GVX_TRY(read_block(page, block, {out, block_bytes}));
        continue;
      }
      if (block_bytes > kMostBlockBytes) return error(page, "strips: expected at most 2 GiB each");
      block_.resize(block_bytes);
      GVX_TRY(read_block(page, block, block_));
      for (std::size_t y = 0; y < in_strip; ++y, out += out_row) {
        const StoredRow row{block_.data() + y * row_bytes, page.bits, page.floating, together};
        for (int s = 0; s < (page.separate ? 1 : count); ++s) {
          unpack_samples(row, page.separate ? 0 : first + s, page.width, page.type,
                         out + static_cast<std::size_t>(plane + s) * bytes, target.pixel_bytes);
        }
      }
    }
  }
  return {};
}

Status TiffFile::read_tiles(const TiffPage& page, int first, int count, const TiffTarget& target) {
  const std::int64_t tile_width = tiff_field<std::uint32_t>(tiff_, TIFFTAG_TILEWIDTH, 0);
  const std::int64_t tile_height = tiff_field<std::uint32_t>(tiff_, TIFFTAG_TILELENGTH, 0);
  if (tile_width == 0 || tile_height == 0)
    return error(page, "tiles: expected a width and a height, found 0");
  const std::int64_t across = (page.width + tile_width - 1) / tile_width;
  const std::int64_t down = (page.height + tile_height - 1) / tile_height;
  const int together = page.separate ? 1 : page.samples;
  const std::size_t bytes = sample_bytes(page.type);
  const auto row_bytes = static_cast<std::size_t>(TIFFTileRowSize64(tiff_));
  const bool direct = stored_as_handed_out(page) && count == together &&
                      target.pixel_bytes == static_cast<std::size_t>(count) * bytes;
  const std::uint64_t tile_bytes = TIFFTileSize64(tiff_);
  if (tile_bytes > kMostBlockBytes) return error(page, "tiles: expected at most 2 GiB each");
  block_.resize(static_cast<std::size_t>(tile_bytes));
  for (std::int64_t i = 0; i < across * down * (page.separate ? count : 1); ++i) {
    const auto plane = static_cast<int>(i / (across * down));
    const std::int64_t x = i % across * tile_width, y = i / across % down * tile_height;
    const std::int64_t columns = std::min(tile_width, page.width - x),
                       rows = std::min(tile_height, page.height - y);
    const std::int64_t tile = i + (page.separate ? first * across * down : 0);
    GVX_TRY(read_block(page, static_cast<std::uint32_t>(tile), block_));
    for (std::int64_t j = 0; j < rows; ++j) {
      std::byte* out = target.begin + static_cast<std::size_t>((y + j) * page.width + x) * target.pixel_bytes;
      const StoredRow row{block_.data() + static_cast<std::size_t>(j) * row_bytes, page.bits, page.floating,
                          together};
      if (direct) {
        std::memcpy(out, row.begin, static_cast<std::size_t>(columns) * target.pixel_bytes);
        continue;
      }
      for (int s = 0; s < (page.separate ? 1 : count); ++s) {
        unpack_samples(row, page.separate ? 0 : first + s, columns, page.type,
                       out + static_cast<std::size_t>(plane + s) * bytes, target.pixel_bytes);
      }
    }
  }
  return {};
}

/// Row by row, so that no more than one is held beside the target.
Status TiffFile::read_raw(const TiffPage& page, int first, int count, const TiffTarget& target) {
  if (!bytes_) {
    GVX_ASSIGN(FileSource source, FileSource::open(path_));
    bytes_.emplace(std::move(source));
  }
  GVX_TRY(bytes_->seek(page.raw_position));
  const auto width = static_cast<std::size_t>(page.width);
  const std::size_t bytes = sample_bytes(page.type);
  block_.resize(width * static_cast<std::size_t>(page.samples) * bytes);
  for (std::int64_t y = 0; y < page.height; ++y) {
    GVX_ASSIGN(const std::size_t read, bytes_->read(block_));
    if (read < block_.size()) return error(page, "the samples end early");
    if (page.big_endian != (std::endian::native == std::endian::big)) {
      for (std::size_t at = 0; at < block_.size() && bytes > 1; at += bytes)
        std::reverse(block_.data() + at, block_.data() + at + bytes);
    }
    const StoredRow row{block_.data(), page.bits, page.floating, page.samples};
    for (int s = 0; s < count; ++s) {
      unpack_samples(row, first + s, page.width, page.type,
                     target.begin + static_cast<std::size_t>(y) * width * target.pixel_bytes +
                         static_cast<std::size_t>(s) * bytes,
                     target.pixel_bytes);
    }
  }
  return {};
}

}  // namespace gvx::io
