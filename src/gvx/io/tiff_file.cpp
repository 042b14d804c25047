#include "gvx/io/tiff_file.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <tiffio.h>
#include <unistd.h>

#include "gvx/io/header_text.h"
#include "gvx/io/tiff_field.h"

namespace gvx::io {
namespace {

constexpr std::uint64_t kMostTileBytes = std::uint64_t{1} << 31;
// What libtiff may take at once beside the file's own bytes: tables of codecs, rows of predictors.
constexpr std::uint64_t kMostExtraBytes = std::uint64_t{256} << 20;
constexpr std::size_t kMostImageJBytes = std::size_t{4} << 20;
constexpr ttag_t kImageJCounts = 50838, kImageJMetadata = 50839;

/// The most bytes that one stored byte can become.
std::uint64_t greatest_ratio(int compression) {
  switch (compression) {
    case COMPRESSION_NONE:
      return 1;
    case COMPRESSION_PACKBITS:
      return 128;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
      return 1040;
    case COMPRESSION_LZW:
      return 4096;
    default:
      return 65536;
  }
}

const char* photometric_name(int photometric) {
  switch (photometric) {
    case PHOTOMETRIC_MASK:
      return "a transparency mask";
    case PHOTOMETRIC_SEPARATED:
      return "CMYK";
    case PHOTOMETRIC_YCBCR:
      return "YCbCr";
    case PHOTOMETRIC_CIELAB:
    case PHOTOMETRIC_ICCLAB:
    case PHOTOMETRIC_ITULAB:
      return "CIE L*a*b*";
    case PHOTOMETRIC_CFA:
    case 34892:
      return "a camera's raw samples";
    case PHOTOMETRIC_LOGL:
    case PHOTOMETRIC_LOGLUV:
      return "LogLuv";
    default:
      return "an unknown one";
  }
}

/// Sets type, bits and floating; says what is wrong, or nothing.
std::string describe_type(TIFF* tiff, TiffPage& page) {
  const int bits = tiff_field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE, 1);
  const int format = tiff_field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  page.bits = bits;
  page.floating = format == SAMPLEFORMAT_IEEEFP;
  if (format == SAMPLEFORMAT_COMPLEXINT || format == SAMPLEFORMAT_COMPLEXIEEEFP) {
    return "samples: expected " + std::string(kSampleTypeNames) + ", found complex numbers";
  }
  if (page.floating && (bits == 16 || bits == 32 || bits == 64)) {
    page.type = bits == 64 ? SampleType::f64 : SampleType::f32;
    return {};
  }
  if (page.floating || bits < 1 || (bits > 32 && bits != 64)) {
    return "samples: expected integers of 1 to 32 or 64 bits or floats of 16, 32 or 64, found " +
           std::string(page.floating ? "floats" : "integers") + " of " + std::to_string(bits);
  }
  const bool is_signed = format == SAMPLEFORMAT_INT;
  page.type = bits <= 8    ? (is_signed ? SampleType::i8 : SampleType::u8)
              : bits <= 16 ? (is_signed ? SampleType::i16 : SampleType::u16)
              : bits <= 32 ? (is_signed ? SampleType::i32 : SampleType::u32)
                           : (is_signed ? SampleType::i64 : SampleType::u64);
  return {};
}

/// Sets what the samples mean; says what is wrong, or nothing.
std::string describe_colors(TIFF* tiff, int compression, TiffPage& page) {
  std::uint16_t extra_count = 0;
  std::uint16_t* extra = nullptr;
  TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &extra_count, &extra);
  for (int i = 0; i < extra_count && extra != nullptr && extra_count < page.samples; ++i) {
    if (extra[i] == EXTRASAMPLE_UNSPECIFIED) continue;
    page.alpha_sample = page.samples - extra_count + i;
    break;
  }
  const int photometric = tiff_field<std::uint16_t>(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  switch (photometric) {
    case PHOTOMETRIC_MINISBLACK:
      return {};
    case PHOTOMETRIC_MINISWHITE:
      page.colors = TiffColors::min_is_white;
      return {};
    case PHOTOMETRIC_PALETTE:
      page.colors = TiffColors::palette;
      return {};
    case PHOTOMETRIC_RGB:
      if (page.samples < 3) break;
      page.colors = TiffColors::rgb;
      return {};
    case PHOTOMETRIC_YCBCR:
      if (compression != COMPRESSION_JPEG || page.samples != 3 || page.separate) break;
      TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
      page.colors = TiffColors::rgb;
      return {};
    default:
      break;
  }
  return "photometric interpretation: expected gray, RGB or palette, found " +
         std::string(photometric == PHOTOMETRIC_RGB ? "RGB of fewer than 3 samples"
                                                    : photometric_name(photometric));
}

std::string describe_compression(int compression) {
  if (TIFFIsCODECConfigured(static_cast<std::uint16_t>(compression)) == 1 && compression != COMPRESSION_OJPEG)
    return {};
  const TIFFCodec* codec = TIFFFindCODEC(static_cast<std::uint16_t>(compression));
  const std::string name = codec != nullptr                               ? codec->name
                           : compression == 33003 || compression == 33005 ? "JPEG 2000"
                           : compression == 34712                         ? "JPEG 2000"
                                                                          : "scheme";
  return "compression: " + name + " " + std::to_string(compression) + " is not read";
}

/// Keeps the first of the errors in the string, fit for one line.
int keep_error(TIFF* /*tiff*/, void* first_error, const char* /*module*/, const char* format,
               va_list arguments) {
  std::string& first = *static_cast<std::string*>(first_error);
  if (!first.empty()) return 1;
  std::array<char, 400> text{};
  std::vsnprintf(text.data(), text.size(), format, arguments);
  first = text.data();
  for (char& c : first) {
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
  }
  while (!first.empty() && (first.back() == '.' || first.back() == ' ')) first.pop_back();
  return 1;
}

int drop_warning(TIFF*, void*, const char*, const char*, va_list) {
  return 1;
}

}  // namespace

Result<std::unique_ptr<TiffFile>> TiffFile::open(const std::string& path) {
  std::unique_ptr<TiffFile> file(new TiffFile(path));
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return file_error(path, "expected a TIFF file, not a folder, pipe or device");
  }
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return file_error(path, "cannot open: " + std::system_category().message(errno));
  file->size_bytes_ = std::filesystem::file_size(path, failure);
  file->complaint_ = std::make_unique<std::string>();
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, keep_error, file->complaint_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options, drop_warning, nullptr);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, static_cast<tmsize_t>(file->size_bytes_ + kMostExtraBytes));
  // m: not mapped, since a mapped file that another process cuts short ends the program; h: no page is read.
  file->tiff_ = TIFFFdOpenExt(descriptor, path.c_str(), "rmh", options);
  TIFFOpenOptionsFree(options);
  if (file->tiff_ == nullptr) {
    ::close(descriptor);
    return file_error(path, "not a TIFF file: " + *file->complaint_);
  }
  return file;
}

TiffFile::~TiffFile() {
  if (tiff_ != nullptr) TIFFClose(tiff_);
}

Error TiffFile::error(const TiffPage& page, const std::string& message) const {
  return file_error(path_, (page_count_ == 1 ? "" : "page " + std::to_string(page.number) + ": ") + message);
}

Error TiffFile::complaint(const TiffPage& page, const std::string& message) const {
  return error(page, message + (complaint_->empty() ? "" : " (" + *complaint_ + ")"));
}

Result<std::vector<TiffPage>> TiffFile::pages() {
  std::vector<TiffPage> pages;
  while (TIFFLastDirectory(tiff_) == 0) {
    TiffPage next;
    next.number = static_cast<std::int64_t>(pages.size()) + 1;
    complaint_->clear();
    if (TIFFReadDirectory(tiff_) != 1) {
      // libtiff stands at the directory only where it has found it.
      const std::uint64_t position = TIFFCurrentDirOffset(tiff_);
      const bool found = position != (pages.empty() ? 0 : pages.back().position);
      GVX_ASSIGN(const bool whole, is_whole_directory(position));
      for (const auto& [tag, name] :
           {std::pair{TIFFTAG_IMAGEWIDTH, "ImageWidth"}, {TIFFTAG_IMAGELENGTH, "ImageLength"}}) {
        std::uint32_t size = 1;
        if (found && TIFFGetField(tiff_, static_cast<ttag_t>(tag), &size) == 1 && size == 0)
          return error(next, std::string(name) + ": expected 1 or more, found 0");
      }
      return complaint(next, found && whole
                                 ? "cannot be read"
                                 : "cannot be read: the list of pages of the TIFF file is broken or comes "
                                   "back to an earlier one");
    }
    GVX_ASSIGN(next, describe_page(next.number));
    if (next.unreadable.empty() && !next.reduced) GVX_TRY(check_blocks(next));
    if (pages.empty()) read_tags();
    pages.push_back(std::move(next));
  }
  if (pages.empty()) return file_error(path_, "expected a TIFF file with at least one page, found none");
  // libtiff takes a directory whose end is cut off, where the position of the next one stands, for the last.
  GVX_ASSIGN(const bool whole, is_whole_directory(pages.back().position));
  if (!whole) return error(pages.back(), "the list of pages ends early: the file is cut short");
  page_count_ = static_cast<std::int64_t>(pages.size());
  return pages;
}

Result<bool> TiffFile::is_whole_directory(std::uint64_t position) const {
  const bool big = TIFFIsBigTIFF(tiff_) != 0, big_endian = TIFFIsBigEndian(tiff_) != 0;
  std::array<std::byte, 8> stored{};
  const auto count_bytes = std::span(stored).first(big ? 8 : 2);
  if (position >= size_bytes_) return false;
  GVX_ASSIGN(FileSource source, FileSource::open(path_));
  GVX_TRY(source.seek(position));
  GVX_ASSIGN(const std::size_t read, source.read(count_bytes));
  std::uint64_t entries = 0;
  for (std::size_t i = 0; i < read; ++i) {
    entries = entries << 8 | std::to_integer<std::uint64_t>(count_bytes[big_endian ? i : read - 1 - i]);
  }
  const std::uint64_t rest = size_bytes_ - std::min(size_bytes_, position + count_bytes.size());
  return entries < rest / (big ? 20 : 12) + 1 && entries * (big ? 20 : 12) + (big ? 8 : 4) <= rest;
}

Result<TiffPage> TiffFile::describe_page(std::int64_t number) {
  TiffPage page;
  page.number = number;
  page.position = TIFFCurrentDirOffset(tiff_);
  page.width = tiff_field<std::uint32_t>(tiff_, TIFFTAG_IMAGEWIDTH, 0);
  page.height = tiff_field<std::uint32_t>(tiff_, TIFFTAG_IMAGELENGTH, 0);
  if (page.width == 0 || page.height == 0) return error(page, "expected a width and a height, found 0");
  page.samples = tiff_field<std::uint16_t>(tiff_, TIFFTAG_SAMPLESPERPIXEL, 1);
  if (page.samples == 0) return error(page, "samples per pixel: expected 1 or more, found 0");
  page.separate = page.samples > 1 && tiff_field<std::uint16_t>(tiff_, TIFFTAG_PLANARCONFIG,
                                                                PLANARCONFIG_CONTIG) == PLANARCONFIG_SEPARATE;
  page.reduced = (tiff_field<std::uint32_t>(tiff_, TIFFTAG_SUBFILETYPE, 0) &
                  (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
  page.orientation = tiff_field<std::uint16_t>(tiff_, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT);
  page.big_endian = TIFFIsBigEndian(tiff_) != 0;
  const int compression = tiff_field<std::uint16_t>(tiff_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  page.unreadable = describe_compression(compression);
  const std::string of_colors = describe_colors(tiff_, compression, page);
  if (page.unreadable.empty()) page.unreadable = of_colors;
  const std::string of_type = describe_type(tiff_, page);
  if (page.unreadable.empty()) page.unreadable = of_type;
  if (compression == COMPRESSION_NONE && TIFFIsTiled(tiff_) == 0 && !page.separate) {
    page.raw_position = TIFFGetStrileOffset(tiff_, 0);
  }
  return page;
}

/// All strips or tiles lie within the file, and hold enough for what they are to become.
Status TiffFile::check_blocks(const TiffPage& page) const {
  const bool tiled = TIFFIsTiled(tiff_) != 0;
  const std::uint32_t blocks = tiled ? TIFFNumberOfTiles(tiff_) : TIFFNumberOfStrips(tiff_);
  const int compression = tiff_field<std::uint16_t>(tiff_, TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  const std::int64_t rows =
      std::min<std::int64_t>(tiff_field<std::uint32_t>(tiff_, TIFFTAG_ROWSPERSTRIP, UINT32_MAX), page.height);
  if (blocks == 0 || rows == 0) return error(page, "expected strips or tiles, found none");
  const std::int64_t strips = (page.height + rows - 1) / rows;
  std::uint64_t stored = 0, whole = 0;
  for (std::uint32_t i = 0; i < blocks; ++i) {
    const auto wrong = [&](const std::string& what) {
      return error(page, (tiled ? "tile " : "strip ") + std::to_string(i + 1) + " of " +
                             std::to_string(blocks) + " " + what);
    };
    int failed = 0;
    const std::uint64_t begin = TIFFGetStrileOffsetWithErr(tiff_, i, &failed);
    const std::uint64_t bytes = failed != 0 ? 0 : TIFFGetStrileByteCountWithErr(tiff_, i, &failed);
    if (failed != 0) return wrong("has no place in the file");
    if (begin == 0 && bytes == 0) continue;  // nothing was stored: zeros
    if (begin < (TIFFIsBigTIFF(tiff_) != 0 ? 16 : 8)) {
      return wrong("begins at byte " + std::to_string(begin) + ", within the header of the file (" +
                   (tiled ? "TileOffsets" : "StripOffsets") + ")");
    }
    if (begin > size_bytes_ || bytes > size_bytes_ - begin) {
      return wrong("ends behind the file's " + std::to_string(size_bytes_) +
                   " bytes: the file is cut short or broken");
    }
    const std::int64_t strip_rows = std::min(rows, page.height - (i % strips) * rows);
    const std::uint64_t becomes =
        tiled ? TIFFTileSize64(tiff_) : TIFFVStripSize64(tiff_, static_cast<std::uint32_t>(strip_rows));
    if (becomes == 0) return complaint(page, "has an impossible size");
    if (compression == COMPRESSION_NONE && bytes < becomes) {
      return wrong("holds " + std::to_string(bytes) + " bytes, expected " + std::to_string(becomes));
    }
    stored += bytes;
    whole = std::max(whole, becomes);
  }
  const std::uint64_t most = (stored + 4096) * greatest_ratio(compression);
  if (stored > 0 && stored < UINT64_MAX / 65536 - 4096 && whole > most) {
    return error(page, "a strip or tile of " + std::to_string(whole) + " bytes cannot come from the " +
                           std::to_string(stored) + " that are stored");
  }
  if (tiled && whole > kMostTileBytes) {
    return error(page, "tiles: expected at most 2 GiB, found " + std::to_string(whole) + " bytes");
  }
  return {};
}

void TiffFile::read_tags() {
  const char* text = nullptr;
  if (TIFFGetField(tiff_, TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr) tags_.description = text;
  for (const int axis : {0, 1}) {
    float resolution = 0;
    if (TIFFGetField(tiff_, axis == 0 ? TIFFTAG_XRESOLUTION : TIFFTAG_YRESOLUTION, &resolution) == 1)
      tags_.resolution[static_cast<std::size_t>(axis)] = static_cast<double>(resolution);
  }
  tags_.resolution_unit = tiff_field<std::uint16_t>(tiff_, TIFFTAG_RESOLUTIONUNIT, RESUNIT_INCH);
  const auto values_of = [&](ttag_t tag, TIFFDataType type) {
    const TIFFField* field = TIFFFindField(tiff_, tag, TIFF_ANY);
    std::uint32_t count = 0;
    const void* values = nullptr;
    const bool there = field != nullptr && TIFFFieldPassCount(field) != 0 &&
                       TIFFFieldReadCount(field) == TIFF_VARIABLE2 && TIFFFieldDataType(field) == type &&
                       TIFFGetField(tiff_, tag, &count, &values) == 1;
    const std::size_t bytes =
        there && values != nullptr ? std::size_t{count} * (type == TIFF_LONG ? 4 : 1) : 0;
    return bytes <= kMostImageJBytes ? std::span(static_cast<const std::byte*>(values), bytes)
                                     : std::span<const std::byte>{};
  };
  const auto counts = values_of(kImageJCounts, TIFF_LONG);
  tags_.imagej_counts.resize(counts.size() / 4);
  if (!counts.empty()) std::memcpy(tags_.imagej_counts.data(), counts.data(), counts.size());
  const auto metadata = values_of(kImageJMetadata, TIFF_BYTE);
  tags_.imagej_metadata.assign(metadata.begin(), metadata.end());
}

Status TiffFile::select(const TiffPage& page) {
  complaint_->clear();
  if (TIFFCurrentDirOffset(tiff_) == page.position) return {};
  if (TIFFSetSubDirectory(tiff_, page.position) != 1) return complaint(page, "cannot be read");
  complaint_->clear();
  // The file may be another one by now: what its pages are is known from when it was opened.
  GVX_ASSIGN(const TiffPage now, describe_page(page.number));
  if (!same_shape(now, page) || now.separate != page.separate)
    return error(page, "has changed since it was opened");
  return {};
}

}  // namespace gvx::io
