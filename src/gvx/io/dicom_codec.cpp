#include "gvx/io/dicom_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

#include "gvx/io/header_text.h"

#ifdef GVX_WITH_GDCM
#include <chrono>

#include <gdcmDataElement.h>
#include <gdcmFragment.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTransferSyntax.h>

#include "gvx/io/isolated.h"
#endif

namespace gvx::io {
namespace {

std::size_t byte_at(std::span<const std::byte> code, std::size_t at) {
  return std::to_integer<std::size_t>(code[at]);
}

/// Big-endian, as JPEG's headers are.
std::size_t word_at(std::span<const std::byte> code, std::size_t at) {
  return byte_at(code, at) << 8 | byte_at(code, at + 1);
}

/// What a code says of itself.
struct CodedFrame {
  std::size_t columns = 0, rows = 0, samples = 0;
  int bits = 0;
  bool luminance = false;  // three samples are luminance and colour differences, whatever the file says
};

/// The start of frame of JPEG (ISO 10918-1, B.2.2) and JPEG-LS (ISO 14495-1, C.2.2).
std::optional<CodedFrame> find_jpeg_frame(std::span<const std::byte> code) {
  if (code.size() < 4 || word_at(code, 0) != 0xFFD8) return std::nullopt;
  std::size_t at = 2;
  bool jfif = false;
  while (at + 4 <= code.size()) {
    if (byte_at(code, at) != 0xFF) return std::nullopt;
    const std::size_t marker = byte_at(code, at + 1);
    if (marker == 0xFF) {
      ++at;
      continue;
    }
    const std::size_t length = word_at(code, at + 2);
    const bool starts_frame =
        (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC) ||
        marker == 0xF7;
    if (starts_frame) {
      if (at + 10 > code.size()) return std::nullopt;
      CodedFrame frame{word_at(code, at + 7), word_at(code, at + 5), byte_at(code, at + 9),
                       static_cast<int>(byte_at(code, at + 4))};
      // JFIF has no other colours; lossless codes and the file's own word hold where it is not JFIF.
      frame.luminance = jfif && marker != 0xC3 && frame.samples == 3 && frame.bits == 8;
      return frame;
    }
    jfif = jfif || (marker == 0xE0 && at + 8 <= code.size() && word_at(code, at + 4) == 0x4A46 &&
                    word_at(code, at + 6) == 0x4946);
    if (marker == 0xDA || marker == 0xD9 || length < 2) return std::nullopt;
    at += 2 + length;
  }
  return std::nullopt;
}

/// The image and tile size of JPEG 2000 (ISO 15444-1, A.5.1).
std::optional<CodedFrame> find_jpeg_2000_frame(std::span<const std::byte> code) {
  constexpr std::byte kStart[] = {std::byte{0xFF}, std::byte{0x4F}, std::byte{0xFF}, std::byte{0x51}};
  // Some writers wrap the code in the boxes of a .jp2 file.
  const auto head = code.first(std::min<std::size_t>(code.size(), 4096));
  const auto found = std::search(head.begin(), head.end(), std::begin(kStart), std::end(kStart));
  const auto at = static_cast<std::size_t>(found - head.begin());
  if (found == head.end() || at + 45 > code.size()) return std::nullopt;
  const auto number = [&](std::size_t offset) {
    return word_at(code, at + offset) << 16 | word_at(code, at + offset + 2);
  };
  const std::size_t x_end = number(8), y_end = number(12), x = number(16), y = number(20);
  const std::size_t tile_x = number(24), tile_y = number(28);
  // A code of many tiles makes the decoder keep a table of them before it has seen one.
  if (x_end <= x || y_end <= y || tile_x == 0 || tile_y == 0 ||
      (x_end / tile_x + 1) * (y_end / tile_y + 1) > 65535)
    return std::nullopt;
  return CodedFrame{x_end - x, y_end - y, word_at(code, at + 40),
                    static_cast<int>(byte_at(code, at + 42) & 0x7F) + 1};
}

/// PackBits of byte planes, the highest byte of a sample first (PS3.5, section G).
Result<std::vector<std::byte>> decode_run_lengths(const std::string& path, const DicomPixelFormat& format,
                                                  std::span<const std::byte> code) {
  constexpr std::size_t kHeaderBytes = 64;
  const auto number = [&](std::size_t i) {
    std::uint32_t value = 0;
    for (std::size_t b = 4; b-- > 0;)
      value = value << 8 | static_cast<std::uint32_t>(byte_at(code, 4 * i + b));
    return static_cast<std::size_t>(value);
  };
  const auto bytes = static_cast<std::size_t>(format.bits_allocated / 8);
  const std::size_t planes = bytes * static_cast<std::size_t>(format.samples);
  if (code.size() < kHeaderBytes || number(0) != planes || planes > 15) {
    return file_error(path, "RLE: expected " + std::to_string(planes) + " segments in a frame");
  }
  const auto pixels = static_cast<std::size_t>(format.rows * format.columns);
  // A code of two bytes holds at most 128: what holds less is not made room for.
  if (pixels / 64 > code.size()) return file_error(path, "RLE: a frame is too short for its pixels");
  std::vector<std::byte> out(pixels * planes);
  for (std::size_t plane = 0; plane < planes; ++plane) {
    const std::size_t begin = number(1 + plane), end = plane + 1 < planes ? number(2 + plane) : code.size();
    if (begin < kHeaderBytes || begin > end || end > code.size()) {
      return file_error(path, "RLE: segment " + std::to_string(plane + 1) + " lies outside its frame");
    }
    const std::size_t from_top = plane % bytes;
    const std::size_t in_sample =
        std::endian::native == std::endian::little ? bytes - 1 - from_top : from_top;
    std::byte* to = out.data() + plane / bytes * bytes + in_sample;
    std::size_t done = 0;
    const auto put = [&](std::byte value) { to[done++ * planes] = value; };
    for (std::size_t at = begin; at + 1 < end && done < pixels;) {
      const std::size_t control = byte_at(code, at++);
      if (control < 128) {
        const std::size_t length = std::min({control + 1, end - at, pixels - done});
        for (std::size_t i = 0; i < length; ++i) put(code[at + i]);
        at += control + 1;
      } else if (control > 128) {
        const std::size_t length = std::min(257 - control, pixels - done);
        for (std::size_t i = 0; i < length; ++i) put(code[at]);
        ++at;
      }
    }
    if (done < pixels)
      return file_error(path, "RLE: segment " + std::to_string(plane + 1) + " ends after " +
                                  std::to_string(done) + " of " + std::to_string(pixels) + " pixels");
  }
  return out;
}

#ifdef GVX_WITH_GDCM

const char* name_of(DicomPacking packing) {
  return packing == DicomPacking::jpeg_2000 ? "JPEG 2000"
         : packing == DicomPacking::jpeg_ls ? "JPEG-LS"
                                            : "JPEG";
}

// Of one frame.
constexpr std::chrono::seconds kPatience{60};

/// Writes a frame of samples of 8 or 16 bits, as the code has them, to `out`; false where it is broken.
bool decode_with_gdcm(const std::string& syntax, const DicomPixelFormat& format, const CodedFrame& coded,
                      std::span<const std::byte> code, std::span<std::byte> out) {
  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, static_cast<unsigned>(format.columns));
  image.SetDimension(1, static_cast<unsigned>(format.rows));
  const auto allocated = static_cast<unsigned short>(coded.bits <= 8 ? 8 : 16);
  const auto bits = static_cast<unsigned short>(coded.bits);
  image.SetPixelFormat(gdcm::PixelFormat(static_cast<unsigned short>(format.samples), allocated, bits,
                                         static_cast<unsigned short>(bits - 1), format.is_signed ? 1 : 0));
  image.SetPhotometricInterpretation(format.samples == 1 ? gdcm::PhotometricInterpretation::MONOCHROME2
                                     : format.color == DicomColor::ybr
                                         ? gdcm::PhotometricInterpretation::YBR_FULL
                                         : gdcm::PhotometricInterpretation::RGB);
  image.SetPlanarConfiguration(0);
  image.SetTransferSyntax(gdcm::TransferSyntax(gdcm::TransferSyntax::GetTSType(syntax.c_str())));
  gdcm::Fragment fragment;
  fragment.SetByteValue(reinterpret_cast<const char*>(code.data()), static_cast<std::uint32_t>(code.size()));
  const gdcm::SmartPointer<gdcm::SequenceOfFragments> fragments = gdcm::SequenceOfFragments::New();
  fragments->AddFragment(fragment);
  gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
  pixels.SetVR(gdcm::VR::OB);
  pixels.SetValue(*fragments);
  image.SetDataElement(pixels);
  return image.GetBufferLength() == out.size() && image.GetBuffer(reinterpret_cast<char*>(out.data()));
}

/// The same, isolated: GDCM prints, and stops the program, where a code is broken.
Result<std::vector<std::byte>> decode_isolated(const std::string& path, DicomPacking packing,
                                               const std::string& syntax, const DicomPixelFormat& format,
                                               const CodedFrame& coded, std::span<const std::byte> code) {
  std::vector<std::byte> out(static_cast<std::size_t>(format.rows * format.columns * format.samples) *
                             (coded.bits <= 8 ? 1 : 2));
  const std::string name = name_of(packing);
  switch (run_isolated(out, kPatience, [&](std::byte* to) {
    return decode_with_gdcm(syntax, format, coded, code, std::span(to, out.size()));
  })) {
    case IsolatedOutcome::done:
      return out;
    case IsolatedOutcome::no_process:
      return file_error(path, name + ": no process or memory to decode a frame with");
    case IsolatedOutcome::too_long:
      return file_error(path, name + ": a frame took more than 60 s to decode");
    default:
      break;
  }
  return file_error(path, name + ": the pixels are broken");
}

/// Samples of 8 bits as those of 16 or 32, those of 16 as those of 32.
std::vector<std::byte> widened(const std::vector<std::byte>& samples, std::size_t from, std::size_t to) {
  if (from == to) return samples;
  std::vector<std::byte> wide(samples.size() / from * to);
  for (std::size_t i = 0; i < samples.size() / from; ++i) {
    std::uint32_t value = 0;
    if constexpr (std::endian::native == std::endian::little) {
      std::memcpy(&value, samples.data() + i * from, from);
      std::memcpy(wide.data() + i * to, &value, to);
    } else {
      std::memcpy(wide.data() + (i + 1) * to - from, samples.data() + i * from, from);
    }
  }
  return wide;
}

#endif

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

}  // namespace

std::array<std::uint8_t, 3> rgb_of_ybr(double y, double b, double r) {
  return {to_byte(y + 1.402 * (r - 128)), to_byte(y - 0.344136 * (b - 128) - 0.714136 * (r - 128)),
          to_byte(y + 1.772 * (b - 128))};
}

Result<std::vector<std::byte>> decode_dicom_frame(const std::string& path, DicomPacking packing,
                                                  const std::string& transfer_syntax,
                                                  const DicomPixelFormat& format,
                                                  std::span<const std::byte> code) {
  if (format.bits_allocated < 8 || format.floating) {
    return file_error(path, "expected packed pixels of 8, 16 or 32 bits");
  }
  if (packing == DicomPacking::rle) return decode_run_lengths(path, format, code);
#ifdef GVX_WITH_GDCM
  const auto coded = packing == DicomPacking::jpeg_2000 ? find_jpeg_2000_frame(code) : find_jpeg_frame(code);
  const std::string name = name_of(packing);
  if (!coded) return file_error(path, name + ": expected a code that begins with its size");
  if (coded->columns != static_cast<std::size_t>(format.columns) ||
      coded->rows != static_cast<std::size_t>(format.rows) ||
      coded->samples != static_cast<std::size_t>(format.samples)) {
    return file_error(path, name + ": the file says " + std::to_string(format.columns) + " x " +
                                std::to_string(format.rows) + " pixels of " + std::to_string(format.samples) +
                                " samples, the packed frame " + std::to_string(coded->columns) + " x " +
                                std::to_string(coded->rows) + " of " + std::to_string(coded->samples));
  }
  if (coded->bits < 2 || coded->bits > std::min(16, format.bits_allocated)) {
    return file_error(path, name + ": expected 2 to " + std::to_string(std::min(16, format.bits_allocated)) +
                                " bits a sample, found " + std::to_string(coded->bits));
  }
  GVX_ASSIGN(auto samples, decode_isolated(path, packing, transfer_syntax, format, *coded, code));
  if (coded->luminance && format.color == DicomColor::rgb) {
    for (std::size_t i = 0; i + 2 < samples.size(); i += 3) {
      const auto rgb = rgb_of_ybr(std::to_integer<int>(samples[i]), std::to_integer<int>(samples[i + 1]),
                                  std::to_integer<int>(samples[i + 2]));
      std::memcpy(samples.data() + i, rgb.data(), 3);
    }
  }
  return widened(samples, coded->bits <= 8 ? 1 : 2, static_cast<std::size_t>(format.bits_allocated / 8));
#else
  (void)transfer_syntax;
  return file_error(path,
                    "its pixels are packed as JPEG, JPEG-LS or JPEG 2000: this gvx was built without GDCM, "
                    "which unpacks them (libgdcm-dev)");
#endif
}

}  // namespace gvx::io
