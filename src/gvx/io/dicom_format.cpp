#include "gvx/io/dicom_format.h"

#include <optional>
#include <string>

#include "gvx/io/dicom_tags.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::int64_t kMostFrames = std::int64_t{1} << 20;

Error wrong(const std::string& path, DicomTag tag, const std::string& what) {
  return file_error(path, dicom_tag_name(tag) + ": " + what);
}

Result<std::int64_t> needed(const DicomHeader& header, DicomTag tag, std::int64_t least, std::int64_t most) {
  const std::optional<double> found = header.elements.number(tag);
  if (!found) return wrong(header.path, tag, "is absent");
  if (*found >= static_cast<double>(least) && *found <= static_cast<double>(most))
    return static_cast<std::int64_t>(*found);
  return wrong(
      header.path, tag,
      "expected " + std::to_string(least) + " to " + std::to_string(most) + ", found " + number_text(*found));
}

Result<DicomColor> parse_color(const DicomHeader& header, int samples) {
  const std::string name = header.elements.text(tag::kPhotometric);
  if (samples == 1) {
    if (name == "MONOCHROME1") return DicomColor::inverted_gray;
    if (name == "PALETTE COLOR") return DicomColor::palette;
    if (name == "MONOCHROME2" || name.empty()) return DicomColor::gray;
  } else {
    if (name == "RGB" || name.empty() || name == "YBR_ICT" || name == "YBR_RCT") return DicomColor::rgb;
    if (name == "YBR_FULL") return DicomColor::ybr;
    if (name == "YBR_FULL_422")
      return header.packing == DicomPacking::native ? DicomColor::ybr_422 : DicomColor::ybr;
  }
  return wrong(header.path, tag::kPhotometric,
               samples == 1
                   ? "expected MONOCHROME1, MONOCHROME2 or PALETTE COLOR for one sample a pixel, found " +
                         io::quoted(name)
                   : "expected RGB or YBR for three samples a pixel, found " + io::quoted(name));
}

/// Of all frames, where they are not packed.
std::uint64_t expected_bytes(const DicomPixelFormat& format, std::int64_t frames) {
  const std::uint64_t pixels = static_cast<std::uint64_t>(format.rows * format.columns);
  return format.bits_allocated == 1 ? (pixels * static_cast<std::uint64_t>(frames) + 7) / 8
                                    : format.frame_bytes() * static_cast<std::uint64_t>(frames);
}

/// The bytes of all frames must be there before anything is made room for.
Status check_pixel_bytes(const DicomHeader& header, const DicomPixelFormat& format, std::int64_t frames) {
  if (!header.pixel_bytes) return {};
  const std::uint64_t expected = expected_bytes(format, frames);
  if (*header.pixel_bytes >= expected) return {};
  return wrong(header.path, header.pixel_tag,
               "expected " + std::to_string(expected) + " bytes for " + std::to_string(frames) +
                   (frames == 1 ? " frame of " : " frames of ") + std::to_string(format.columns) + " x " +
                   std::to_string(format.rows) + " pixels, found " + std::to_string(*header.pixel_bytes));
}

}  // namespace

std::uint64_t DicomPixelFormat::frame_bytes() const {
  const auto pixels = static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(columns);
  if (bits_allocated == 1) return (pixels + 7) / 8;
  if (color == DicomColor::ybr_422) return 2 * pixels;
  return pixels * static_cast<std::uint64_t>(samples) * static_cast<std::uint64_t>(bits_allocated / 8);
}

SampleType DicomPixelFormat::type() const {
  if (components() == 3) return SampleType::u8;
  if (floating) return bits_allocated == 32 ? SampleType::f32 : SampleType::f64;
  switch (bits_allocated) {
    case 16:
      return is_signed ? SampleType::i16 : SampleType::u16;
    case 32:
      return is_signed ? SampleType::i32 : SampleType::u32;
    default:
      return is_signed ? SampleType::i8 : SampleType::u8;
  }
}

Result<DicomPixelFormat> interpret_format(const DicomHeader& header) {
  DicomPixelFormat format;
  const DicomDataset& e = header.elements;
  GVX_ASSIGN(format.rows, needed(header, tag::kRows, 1, 65535));
  GVX_ASSIGN(format.columns, needed(header, tag::kColumns, 1, 65535));
  const std::int64_t samples = e.count(tag::kSamplesPerPixel).value_or(1);
  if (samples != 1 && samples != 3) {
    return wrong(header.path, tag::kSamplesPerPixel, "expected 1 or 3, found " + std::to_string(samples));
  }
  format.samples = static_cast<int>(samples);
  format.planar = samples == 3 && e.count(tag::kPlanarConfiguration).value_or(0) == 1;
  format.floating = header.pixel_tag != kPixelData;
  if (format.floating) {
    format.bits_allocated = format.bits_stored = header.pixel_tag == kFloatPixelData ? 32 : 64;
    format.high_bit = format.bits_allocated - 1;
    if (samples != 1)
      return wrong(header.path, tag::kSamplesPerPixel, "expected 1 for floating-point pixels");
    return format;
  }
  GVX_ASSIGN(const std::int64_t allocated, needed(header, tag::kBitsAllocated, 1, 32));
  if (allocated != 1 && allocated != 8 && allocated != 16 && allocated != 32) {
    return wrong(header.path, tag::kBitsAllocated,
                 "expected 1, 8, 16 or 32, found " + std::to_string(allocated));
  }
  format.bits_allocated = static_cast<int>(allocated);
  const std::int64_t stored = e.count(tag::kBitsStored).value_or(allocated);
  if (stored < 1 || stored > allocated) {
    return wrong(header.path, tag::kBitsStored,
                 "expected 1 to " + std::to_string(allocated) + ", found " + std::to_string(stored));
  }
  format.bits_stored = static_cast<int>(stored);
  const std::int64_t high = e.count(tag::kHighBit).value_or(stored - 1);
  if (high < stored - 1 || high >= allocated) {
    return wrong(header.path, tag::kHighBit,
                 "expected " + std::to_string(stored - 1) + " to " + std::to_string(allocated - 1) +
                     ", found " + std::to_string(high));
  }
  format.high_bit = static_cast<int>(high);
  format.is_signed = allocated > 1 && e.count(tag::kPixelRepresentation).value_or(0) == 1;
  GVX_ASSIGN(format.color, parse_color(header, format.samples));
  if (format.components() == 3) {
    if (format.samples == 3 && allocated != 8 && allocated != 16) {
      return wrong(header.path, tag::kBitsAllocated,
                   "expected 8 or 16 for colours, found " + std::to_string(allocated));
    }
    format.is_signed = false;
  }
  if (format.color == DicomColor::ybr_422 && (allocated != 8 || format.planar || format.columns % 2 != 0)) {
    return wrong(header.path, tag::kPhotometric,
                 "expected YBR_FULL_422 of 8 bits side by side and an even number of columns");
  }
  return format;
}

std::uint64_t surplus_pixel_bytes(const DicomHeader& header, const DicomPixelFormat& format,
                                  std::int64_t frames) {
  if (!header.pixel_bytes) return 0;
  const std::uint64_t expected = expected_bytes(format, frames);
  // Values have an even number of bytes.
  const std::uint64_t padded = expected + expected % 2;
  return *header.pixel_bytes > padded ? *header.pixel_bytes - expected : 0;
}

Result<std::int64_t> count_frames(const DicomHeader& header, const DicomPixelFormat& format) {
  std::int64_t frames = 1;
  if (!header.elements.text(tag::kNumberOfFrames).empty()) {
    GVX_ASSIGN(frames, needed(header, tag::kNumberOfFrames, 1, kMostFrames));
  }
  GVX_TRY(check_pixel_bytes(header, format, frames));
  return frames;
}

}  // namespace gvx::io
