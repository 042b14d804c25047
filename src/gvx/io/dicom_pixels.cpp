#include "gvx/io/dicom_pixels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "gvx/io/dicom_codec.h"
#include "gvx/io/dicom_tags.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::uint64_t kLargestPackedFrame = std::uint64_t{1} << 31;
constexpr std::size_t kMostFragments = std::size_t{1} << 22;

std::uint32_t little_endian_at(const std::byte* bytes) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | std::to_integer<std::uint32_t>(bytes[i]);
  return value;
}

/// The bits of a stored sample that count, with their sign.
struct Unpacker {
  int shift, bits;
  bool is_signed;

  explicit Unpacker(const DicomPixelFormat& format)
      : shift(format.high_bit + 1 - format.bits_stored),
        bits(format.bits_stored),
        is_signed(format.is_signed) {}

  template <typename Stored>
  std::int64_t operator()(Stored stored) const {
    const std::uint64_t value =
        (static_cast<std::uint64_t>(stored) >> shift) & ((std::uint64_t{1} << bits) - 1);
    const bool negative = is_signed && (value >> (bits - 1) & 1) != 0;
    return static_cast<std::int64_t>(value) - (negative ? std::int64_t{1} << bits : 0);
  }
};

/// Calls function(zero of the unsigned type that stores a sample).
template <typename Function>
void with_stored_type(int bits_allocated, Function&& function) {
  if (bits_allocated <= 8) {
    function(std::uint8_t{});
  } else if (bits_allocated == 16) {
    function(std::uint16_t{});
  } else {
    function(std::uint32_t{});
  }
}

}  // namespace

Status DicomPixels::read_slice(const DicomImage& image, const DicomFrame& frame, std::span<std::byte> out) {
  GVX_TRY(open(image));
  if (frame_number_ != frame.number) {
    frame_number_ = -1;
    GVX_TRY(read_frame(image, frame.number));
    frame_number_ = frame.number;
  }
  convert(image, frame, out);
  return {};
}

Status DicomPixels::open(const DicomImage& image) {
  if (source_ && open_path_ == image.path) return {};
  open_path_.clear();
  frame_number_ = -1;
  codes_.clear();
  GVX_ASSIGN(DicomSource source, DicomSource::open(image.path));
  source_.emplace(std::move(source));
  GVX_ASSIGN(header_, read_dicom_header(*source_));
  const bool has_pixels = header_.pixel_tag != 0;
  GVX_ASSIGN(const DicomImage now, has_pixels
                                       ? interpret_dicom(header_)
                                       : Result<DicomImage>(file_error(image.path, "its pixels are gone")));
  if (!(now.format == image.format) || now.frames.size() != image.frames.size()) {
    return file_error(image.path, "the file has changed since it was opened");
  }
  if (image.format.color == DicomColor::palette) GVX_TRY(read_palette());
  if (header_.packing != DicomPacking::native) GVX_TRY(find_fragments(image));
  // Of all else only the pixels' place is needed from here on.
  header_.elements = {};
  open_path_ = image.path;
  return {};
}

Status DicomPixels::read_bytes(std::uint64_t offset, std::span<std::byte> out) {
  GVX_ASSIGN(const std::size_t done, source_->read(offset, out));
  if (done == out.size()) return {};
  return file_error(source_->name(), dicom_tag_name(header_.pixel_tag) +
                                         ": the file ends within its pixels, at byte " +
                                         std::to_string(offset + done));
}

/// PS3.5, section A.4: an item with the offsets of frames, perhaps empty, and an item for each fragment.
Status DicomPixels::find_fragments(const DicomImage& image) {
  constexpr std::uint32_t kItem = 0xE000FFFE, kEnd = 0xE0DDFFFE;  // as little-endian pairs
  const std::size_t frames = image.tiles > 0 ? 1 : image.frames.size();
  std::uint64_t at = header_.pixel_offset, first_offset = 0;
  std::vector<std::uint32_t> offsets;
  std::vector<Fragment> fragments;
  for (bool table = true;; table = false) {
    std::array<std::byte, 8> start;
    GVX_ASSIGN(const std::size_t size, source_->read(at, start));
    if (!table && size < 8) break;  // the end is often forgotten
    if (size < 8)
      return file_error(image.path, dicom_tag_name(kPixelData) + ": the file ends before the first fragment");
    const std::uint32_t tag = little_endian_at(start.data()), bytes = little_endian_at(start.data() + 4);
    at += 8;
    if (tag == kEnd) break;
    if (tag != kItem)
      return file_error(
          image.path, dicom_tag_name(kPixelData) + ": expected a fragment at byte " + std::to_string(at - 8));
    if (source_->size() && bytes > *source_->size() - std::min(at, *source_->size())) {
      return file_error(image.path, dicom_tag_name(kPixelData) + ": a fragment of " + std::to_string(bytes) +
                                        " bytes goes beyond the end of the file");
    }
    if (!table) {
      fragments.push_back({at, bytes});
      if (fragments.size() > kMostFragments)
        return file_error(image.path, dicom_tag_name(kPixelData) + ": expected at most 2^22 fragments");
    } else if (bytes == 4 * frames) {
      std::vector<std::byte> raw(bytes);
      GVX_TRY(read_bytes(at, raw));
      for (std::size_t i = 0; i < frames; ++i) offsets.push_back(little_endian_at(raw.data() + 4 * i));
    }
    at += bytes;
    if (table) first_offset = at;
  }
  return share_fragments(fragments, offsets, first_offset, frames);
}

Status DicomPixels::share_fragments(const std::vector<Fragment>& fragments,
                                    const std::vector<std::uint32_t>& offsets, std::uint64_t first_offset,
                                    std::size_t frames) {
  codes_.assign(frames, {});
  if (frames == 1 || fragments.size() == frames) {
    for (std::size_t i = 0; i < fragments.size(); ++i) codes_[frames == 1 ? 0 : i].push_back(fragments[i]);
    return {};
  }
  // A frame begins where the table says so, or with a start of image, or of a code of JPEG 2000.
  std::size_t begun = 0;
  for (const Fragment& fragment : fragments) {
    bool begins = false;
    if (!offsets.empty()) {
      begins = begun < frames && fragment.offset - 8 - first_offset == offsets[begun];
    } else {
      std::array<std::byte, 4> magic{};
      GVX_ASSIGN(const std::size_t size, source_->read(fragment.offset, magic));
      begins = size >= 2 && magic[0] == std::byte{0xFF} &&
               (magic[1] == std::byte{0xD8} || magic[1] == std::byte{0x4F});
    }
    begun += begins ? 1 : 0;
    if (begun == 0 || begun > frames) break;
    codes_[begun - 1].push_back(fragment);
  }
  if (begun == frames) return {};
  return file_error(source_->name(), dicom_tag_name(kPixelData) + ": expected the fragments of " +
                                         std::to_string(frames) + " frames, found " +
                                         std::to_string(fragments.size()) +
                                         " fragments that cannot be told apart");
}

Status DicomPixels::read_frame(const DicomImage& image, std::int64_t number) {
  const DicomPixelFormat& format = image.format;
  const std::uint64_t bytes = format.frame_bytes();
  if (header_.packing != DicomPacking::native) {
    std::uint64_t code_bytes = 0;
    for (const Fragment& fragment : codes_[static_cast<std::size_t>(number)]) code_bytes += fragment.bytes;
    if (bytes > kLargestPackedFrame || code_bytes > 2 * bytes + (1 << 20)) {
      return file_error(
          image.path,
          "a packed frame of " + std::to_string(code_bytes) + " bytes for " + std::to_string(bytes) +
              " bytes of pixels: expected less than 2^31 bytes, and no more code than twice the pixels");
    }
    std::vector<std::byte> code(static_cast<std::size_t>(code_bytes));
    std::size_t at = 0;
    for (const Fragment& fragment : codes_[static_cast<std::size_t>(number)]) {
      GVX_TRY(read_bytes(fragment.offset, std::span(code).subspan(at, fragment.bytes)));
      at += fragment.bytes;
    }
    GVX_ASSIGN(frame_,
               decode_dicom_frame(image.path, header_.packing, header_.transfer_syntax, format, code));
    side_by_side_ = true;
    return {};
  }
  side_by_side_ = false;
  if (format.bits_allocated == 1) {
    // Frames follow each other without a gap, the lowest bit of a byte first; one byte a pixel here.
    const auto pixels = static_cast<std::uint64_t>(format.rows * format.columns);
    const std::uint64_t first_bit = pixels * static_cast<std::uint64_t>(number);
    std::vector<std::byte> bits(static_cast<std::size_t>((first_bit % 8 + pixels + 7) / 8));
    GVX_TRY(read_bytes(header_.pixel_offset + first_bit / 8, bits));
    frame_.resize(static_cast<std::size_t>(pixels));
    for (std::size_t i = 0; i < frame_.size(); ++i) {
      const std::size_t bit = static_cast<std::size_t>(first_bit % 8) + i;
      frame_[i] = bits[bit / 8] >> (bit % 8) & std::byte{1};
    }
    return {};
  }
  frame_.resize(static_cast<std::size_t>(bytes));
  GVX_TRY(read_bytes(header_.pixel_offset + bytes * static_cast<std::uint64_t>(number), frame_));
  if (header_.big_endian == (std::endian::native == std::endian::big)) return {};
  const auto width = static_cast<std::ptrdiff_t>(format.bits_allocated / 8);
  for (auto sample = frame_.begin(); width > 1 && sample != frame_.end(); sample += width)
    std::reverse(sample, sample + width);
  return {};
}

/// PS3.3, C.7.6.3.1.5 and C.7.6.3.1.6.
Status DicomPixels::read_palette() {
  for (DicomTag i = 0; i < 3; ++i) {
    const std::vector<double> descriptor = header_.elements.numbers(tag::kRedDescriptor + i);
    const DicomElement* const data = header_.elements.find(tag::kRedData + i);
    if (descriptor.size() < 3 || data == nullptr) {
      return file_error(source_->name(),
                        dicom_tag_name(data == nullptr ? tag::kRedData + i : tag::kRedDescriptor + i) +
                            ": is absent (palettes in segments are not read)");
    }
    const std::size_t count = descriptor[0] == 0 ? 65536 : static_cast<std::size_t>(descriptor[0]);
    palette_.first = static_cast<std::int64_t>(descriptor[1]);
    std::vector<std::uint8_t>& entries = palette_.entries[i];
    entries.clear();
    if (data->value.size() < 2 * count && data->value.size() >= count) {
      entries.assign(data->value.begin(), data->value.begin() + static_cast<std::ptrdiff_t>(count));
      continue;
    }
    const std::vector<double> words = header_.elements.numbers(tag::kRedData + i);
    if (words.size() < count) {
      return file_error(source_->name(), dicom_tag_name(tag::kRedData + i) + ": expected " +
                                             std::to_string(count) + " entries, found " +
                                             std::to_string(words.size()));
    }
    // Some writers say 16 bits and mean 8.
    const bool wide = *std::max_element(words.begin(), words.end()) > 255;
    for (std::size_t e = 0; e < count; ++e)
      entries.push_back(static_cast<std::uint8_t>(wide ? words[e] / 256 : words[e]));
  }
  return {};
}

void DicomPixels::convert(const DicomImage& image, const DicomFrame& frame, std::span<std::byte> out) const {
  const DicomPixelFormat& format = image.format;
  const std::int64_t columns = image.slice_columns(), rows = image.slice_rows();
  const std::int64_t x0 = frame.tile > 0 ? frame.tile % image.tiles_across * columns : 0;
  const std::int64_t y0 = frame.tile > 0 ? frame.tile / image.tiles_across * rows : 0;
  if (format.floating) {
    std::memcpy(out.data(), frame_.data(), out.size());
    return;
  }
  const Unpacker unpack(format);
  const auto pixels = static_cast<std::size_t>(format.rows * format.columns);
  const auto samples = static_cast<std::size_t>(format.samples);
  const bool planar = format.planar && !side_by_side_;
  with_stored_type(format.bits_allocated, [&](auto zero) {
    using Stored = decltype(zero);
    const auto sample = [&](std::size_t i) {
      Stored stored;
      std::memcpy(&stored, frame_.data() + i * sizeof(Stored), sizeof(Stored));
      return unpack(stored);
    };
    if (format.components() == 1) {
      with_sample_type(format.type(), [&](auto value) {
        std::byte* to = out.data();
        for (std::int64_t y = 0; y < rows; ++y) {
          const auto row = static_cast<std::size_t>((y0 + y) * format.columns + x0);
          for (std::int64_t x = 0; x < columns; ++x, to += sizeof value) {
            value = static_cast<decltype(value)>(sample(row + static_cast<std::size_t>(x)));
            std::memcpy(to, &value, sizeof value);
          }
        }
      });
      return;
    }
    // Colours: the highest 8 bits of each sample.
    const int excess = std::max(format.bits_stored - 8, 0);
    for (std::size_t i = 0; i < pixels; ++i) {
      std::array<std::uint8_t, 3> color{};
      if (format.color == DicomColor::palette) {
        for (std::size_t c = 0; c < 3; ++c) {
          const auto& entries = palette_.entries[c];
          const std::int64_t entry = std::clamp<std::int64_t>(sample(i) - palette_.first, 0,
                                                              static_cast<std::int64_t>(entries.size()) - 1);
          color[c] = entries[static_cast<std::size_t>(entry)];
        }
      } else if (format.color == DicomColor::ybr_422) {
        const std::size_t pair = 4 * (i / 2);
        color = rgb_of_ybr(static_cast<double>(sample(pair + i % 2)), static_cast<double>(sample(pair + 2)),
                           static_cast<double>(sample(pair + 3)));
      } else {
        for (std::size_t c = 0; c < 3; ++c) {
          color[c] = static_cast<std::uint8_t>(sample(planar ? c * pixels + i : i * samples + c) >> excess);
        }
        if (format.color == DicomColor::ybr) color = rgb_of_ybr(color[0], color[1], color[2]);
      }
      std::memcpy(out.data() + 3 * i, color.data(), 3);
    }
  });
}

}  // namespace gvx::io
