#include "gvx/io/dicom_elements.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include "gvx/io/dicom_tags.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr DicomTag kItem = 0xFFFEE000, kItemEnd = 0xFFFEE00D, kSequenceEnd = 0xFFFEE0DD;
constexpr std::uint32_t kUndefinedLength = 0xFFFFFFFF;
constexpr std::uint64_t kNowhere = std::numeric_limits<std::uint64_t>::max();
constexpr int kDeepest = 16;
// Of an element that gvx uses, and of those of one file together.
constexpr std::uint64_t kLongestValue = std::uint64_t{1} << 22;
constexpr std::uint64_t kMostElements = std::uint64_t{1} << 23;

constexpr std::string_view kRepresentations =
    "AE AS AT CS DA DS DT FD FL IS LO LT OB OD OF OL OV OW PN SH SL SQ SS ST SV TM UC UI UL UN UR US UT UV ";
constexpr std::string_view kLongRepresentations = "OB OD OF OL OV OW SQ SV UC UN UR UT UV ";

bool is_in(std::string_view list, std::string_view representation) {
  for (std::size_t at = 0; at < list.size(); at += 3) {
    if (list.substr(at, 2) == representation) return true;
  }
  return false;
}

std::size_t width_of(DicomValue value) {
  switch (value) {
    case DicomValue::u16:
    case DicomValue::tag:
      return 2;
    case DicomValue::u32:
    case DicomValue::f32:
      return 4;
    case DicomValue::f64:
      return 8;
    default:
      return 1;
  }
}

/// Walks over the elements of one file.
class Parser {
 public:
  Parser(DicomSource& source, DicomHeader& header) : source_(source), header_(header) {}

  Status parse() {
    GVX_TRY(parse_start());
    GVX_TRY(choose_syntax());
    GVX_TRY(parse_elements(header_.elements, kNowhere, 0, explicit_, true));
    if (header_.pixel_tag != 0) return check_pixels();
    return {};
  }

 private:
  Error wrong(DicomTag tag, const std::string& what) const {
    return file_error(source_.name(), dicom_tag_name(tag) + ": " + what);
  }

  Result<bool> read(std::span<std::byte> out) {
    GVX_ASSIGN(const std::size_t done, source_.read(at_, out));
    at_ += done;
    return done == out.size();
  }

  template <typename T>
  T number_at(const std::byte* bytes) const {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes, sizeof(T));
    if (big_endian_ != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  /// The file meta information, if there is any.
  Status parse_start() {
    std::array<std::byte, kDicomStartBytes> start{};
    GVX_ASSIGN(const std::size_t size, source_.read(0, start));
    const std::string_view text(reinterpret_cast<const char*>(start.data()), size);
    if (!begins_as_dicom(text)) {
      return file_error(source_.name(),
                        "no DICOM file: expected DICM at byte 128, or an element of group 2 or 8 at byte 0");
    }
    at_ = text.substr(std::min<std::size_t>(128, size)).starts_with("DICM") ? 132 : 0;
    const auto group = [&] { return number_at<std::uint16_t>(start.data() + at_); };
    if (at_ + 2 > size || group() != 2) return {};
    return parse_elements(header_.elements, kNowhere, 0, true, false);
  }

  /// What the transfer syntax says of the rest (PS3.5, section A; PS3.6, table A-1).
  Status choose_syntax() {
    const std::string syntax = header_.elements.text(tag::kTransferSyntax);
    header_.transfer_syntax = syntax;
    explicit_ = true;
    if (syntax == "1.2.840.10008.1.2") {
      explicit_ = false;
    } else if (syntax == "1.2.840.113619.5.2") {  // GE's: implicit elements, big-endian pixels
      explicit_ = false;
      header_.big_endian = true;
    } else if (syntax == "1.2.840.10008.1.2.2") {
      big_endian_ = header_.big_endian = true;
    } else if (syntax == "1.2.840.10008.1.2.1.99") {
      header_.deflated_from = at_;
      GVX_TRY(source_.inflate_from(at_));
      at_ = 0;
    } else if (syntax == "1.2.840.10008.1.2.5") {
      header_.packing = DicomPacking::rle;
    } else if (syntax == "1.2.840.10008.1.2.4.80" || syntax == "1.2.840.10008.1.2.4.81") {
      header_.packing = DicomPacking::jpeg_ls;
    } else if (syntax == "1.2.840.10008.1.2.4.90" || syntax == "1.2.840.10008.1.2.4.91") {
      header_.packing = DicomPacking::jpeg_2000;
    } else if (syntax == "1.2.840.10008.1.2.4.50" || syntax == "1.2.840.10008.1.2.4.51" ||
               syntax == "1.2.840.10008.1.2.4.57" || syntax == "1.2.840.10008.1.2.4.70") {
      header_.packing = DicomPacking::jpeg;
    } else if (!syntax.empty() && syntax != "1.2.840.10008.1.2.1") {
      return wrong(tag::kTransferSyntax,
                   "expected little- or big-endian, deflated, RLE, JPEG, JPEG-LS or JPEG 2000, found " +
                       io::quoted(syntax));
    }
    // Some writers use the other representation than they say, and without file meta information nobody says.
    std::array<std::byte, 8> first;
    GVX_ASSIGN(const std::size_t size, source_.read(at_, first));
    if (size == first.size() && !big_endian_) {
      explicit_ =
          is_in(kRepresentations, std::string_view(reinterpret_cast<const char*>(first.data()) + 4, 2));
    }
    return {};
  }

  struct ElementStart {
    DicomTag tag = 0;
    bool sequence = false;  // says the file
    bool unknown = false;
    bool bytes = false;
    std::uint32_t length = 0;
  };

  /// Nothing at the end of the file.
  Result<std::optional<ElementStart>> next_element(bool is_explicit) {
    std::array<std::byte, 8> bytes;
    GVX_ASSIGN(const std::size_t size, source_.read(at_, bytes));
    if (size == 0) return std::optional<ElementStart>();
    if (size < 8) return file_error(source_.name(), "ends within an element, at byte " + std::to_string(at_));
    at_ += 8;
    ElementStart start;
    start.tag = static_cast<DicomTag>(number_at<std::uint16_t>(bytes.data())) << 16 |
                number_at<std::uint16_t>(bytes.data() + 2);
    if (start.tag >> 16 == 0xFFFE || !is_explicit) {
      start.length = number_at<std::uint32_t>(bytes.data() + 4);
      return std::optional(start);
    }
    const std::string_view representation(reinterpret_cast<const char*>(bytes.data()) + 4, 2);
    if (!is_in(kRepresentations, representation)) {
      return wrong(start.tag,
                   "expected a value representation such as US or DS, found " + io::quoted(representation));
    }
    start.sequence = representation == "SQ";
    start.unknown = representation == "UN";
    start.bytes = representation == "OB" || representation == "OW";
    if (!is_in(kLongRepresentations, representation)) {
      start.length = number_at<std::uint16_t>(bytes.data() + 6);
      return std::optional(start);
    }
    std::array<std::byte, 4> length;
    GVX_ASSIGN(const bool whole, read(length));
    if (!whole) return wrong(start.tag, "the file ends within its length");
    start.length = number_at<std::uint32_t>(length.data());
    return std::optional(start);
  }

  /// Elements up to `end`, the end of the item, the end of the file meta information where not `data_set`, or
  /// the pixels.
  Status parse_elements(DicomDataset& out, std::uint64_t end, int depth, bool is_explicit, bool data_set) {
    if (depth > kDeepest) return file_error(source_.name(), "sequences lie more than 16 deep in each other");
    while (at_ < end) {
      const std::uint64_t before = at_;
      if (!data_set) {
        // What follows may be written otherwise, or packed.
        std::array<std::byte, 2> group;
        GVX_ASSIGN(const std::size_t size, source_.read(at_, group));
        if (size == group.size() && number_at<std::uint16_t>(group.data()) != 2) return {};
      }
      GVX_ASSIGN(const std::optional<ElementStart> start, next_element(is_explicit));
      if (!start) {
        if (depth > 0) return file_error(source_.name(), "ends within a sequence");
        return {};
      }
      if (++elements_ > kMostElements) return file_error(source_.name(), "has more than 2^23 elements");
      if (depth > 0 && (start->tag == kItemEnd || start->tag == kSequenceEnd)) {
        if (start->tag == kSequenceEnd) at_ = before;  // an item whose end was forgotten
        return {};
      }
      if (start->tag >> 16 == 0xFFFE) return wrong(start->tag, "an item outside a sequence");
      if (data_set && depth == 0 && is_pixels(*start)) return {};
      GVX_TRY(parse_value(*start, out, end, depth, is_explicit));
    }
    return {};
  }

  bool is_pixels(const ElementStart& start) {
    if (start.tag != kPixelData && start.tag != kFloatPixelData && start.tag != kDoublePixelData)
      return false;
    header_.pixel_tag = start.tag;
    header_.pixel_offset = at_;
    if (start.length != kUndefinedLength) header_.pixel_bytes = start.length;
    return true;
  }

  Status parse_value(const ElementStart& start, DicomDataset& out, std::uint64_t end, int depth,
                     bool is_explicit) {
    const DicomTagEntry* const entry = find_dicom_tag(start.tag);
    // The packed pixels of an icon.
    if (start.bytes && start.length == kUndefinedLength) return skip_fragments(start.tag, end);
    const bool used_sequence = entry != nullptr && entry->value == DicomValue::sequence;
    const bool has_items = start.length == kUndefinedLength ||
                           (used_sequence && (start.sequence || start.unknown || !is_explicit));
    if (has_items) {
      DicomElement element{.tag = start.tag, .value = {}, .items = {}};
      std::uint64_t sequence_end = kNowhere;
      if (start.length != kUndefinedLength) {
        GVX_TRY(check_length(start, end));
        sequence_end = at_ + start.length;
      }
      // PS3.5, 6.2.2: what has VR UN and no length is written in implicit VR.
      GVX_TRY(parse_items(element, sequence_end, depth, is_explicit && !start.unknown));
      if (used_sequence) out.elements.push_back(std::move(element));
      return {};
    }
    GVX_TRY(check_length(start, end));
    if (entry == nullptr || used_sequence || start.length > kLongestValue) {
      at_ += start.length;
      return {};
    }
    return read_value(start, *entry, out);
  }

  Status check_length(const ElementStart& start, std::uint64_t end) const {
    const std::uint64_t file_end = source_.size().value_or(kNowhere);
    if (start.length <= std::min(end, file_end) - std::min(at_, std::min(end, file_end))) return {};
    return wrong(start.tag, "its length, " + std::to_string(start.length) +
                                " bytes, goes beyond the end of the " +
                                (end < file_end ? "sequence" : "file"));
  }

  Status read_value(const ElementStart& start, const DicomTagEntry& entry, DicomDataset& out) {
    DicomElement element{.tag = start.tag, .value = std::string(start.length, '\0'), .items = {}};
    GVX_ASSIGN(const bool whole, read(std::as_writable_bytes(std::span(element.value))));
    if (!whole) return wrong(start.tag, "the file ends within its value");
    const std::size_t width = width_of(entry.value);
    if (big_endian_ != (std::endian::native == std::endian::big)) {
      for (std::size_t i = 0; i + width <= element.value.size(); i += width) {
        std::reverse(element.value.begin() + static_cast<std::ptrdiff_t>(i),
                     element.value.begin() + static_cast<std::ptrdiff_t>(i + width));
      }
    }
    if (start.tag == tag::kMetaLength && element.value.size() == 4) {
      std::uint32_t length;
      std::memcpy(&length, element.value.data(), 4);
      const std::uint64_t file_end = source_.size().value_or(kNowhere);
      if (at_ > file_end || length > file_end - at_) {
        return wrong(start.tag, std::to_string(length) + " bytes go beyond the end of the file");
      }
    }
    out.elements.push_back(std::move(element));
    return {};
  }

  Status skip_fragments(DicomTag tag, std::uint64_t end) {
    while (at_ < end) {
      GVX_ASSIGN(const std::optional<ElementStart> start, next_element(false));
      if (!start) return wrong(tag, "the file ends within its fragments");
      if (start->tag == kSequenceEnd) return {};
      if (start->tag != kItem) return wrong(tag, "expected a fragment, found " + dicom_tag_name(start->tag));
      GVX_TRY(check_length({.tag = tag, .length = start->length}, end));
      at_ += start->length;
    }
    return {};
  }

  Status parse_items(DicomElement& element, std::uint64_t end, int depth, bool is_explicit) {
    while (at_ < end) {
      GVX_ASSIGN(const std::optional<ElementStart> start, next_element(false));
      if (!start) return wrong(element.tag, "the file ends within the sequence");
      if (++elements_ > kMostElements) return file_error(source_.name(), "has more than 2^23 elements");
      if (start->tag == kSequenceEnd) return {};
      if (start->tag != kItem)
        return wrong(element.tag, "expected an item of the sequence, found " + dicom_tag_name(start->tag));
      std::uint64_t item_end = kNowhere;
      if (start->length != kUndefinedLength) {
        GVX_TRY(check_length({.tag = element.tag, .length = start->length}, end));
        item_end = at_ + start->length;
      }
      DicomDataset item;
      GVX_TRY(parse_elements(item, item_end, depth + 1, is_explicit, true));
      const DicomTagEntry* const entry = find_dicom_tag(element.tag);
      if (entry != nullptr && entry->value == DicomValue::sequence) element.items.push_back(std::move(item));
    }
    return {};
  }

  Status check_pixels() const {
    const std::uint64_t file_end = source_.size().value_or(kNowhere);
    const bool packed = header_.packing != DicomPacking::native;
    if (packed && header_.pixel_bytes) {
      return wrong(header_.pixel_tag,
                   "expected fragments, as the transfer syntax is packed, found a length of " +
                       std::to_string(*header_.pixel_bytes) + " bytes");
    }
    if (!packed && !header_.pixel_bytes) {
      return wrong(header_.pixel_tag,
                   "expected a length, as the transfer syntax is not packed, found fragments");
    }
    if (header_.pixel_bytes && header_.pixel_offset + *header_.pixel_bytes > file_end) {
      return wrong(header_.pixel_tag,
                   "expected " + std::to_string(*header_.pixel_bytes) + " bytes, the file ends after " +
                       std::to_string(file_end - std::min(file_end, header_.pixel_offset)));
    }
    return {};
  }

  DicomSource& source_;
  DicomHeader& header_;
  std::uint64_t at_ = 0;
  std::uint64_t elements_ = 0;
  bool explicit_ = true;
  bool big_endian_ = false;
};

}  // namespace

bool begins_as_dicom(std::string_view bytes) {
  if (bytes.size() >= 132 && bytes.substr(128, 4) == "DICM") return true;
  if (bytes.size() < 16) return false;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  // An even group, little-endian, and a low element: (0002,00xx) or (0008,00xx).
  if (byte(1) != 0 || (byte(0) != 2 && byte(0) != 8) || byte(3) != 0) return false;
  if (is_in(kRepresentations, bytes.substr(4, 2))) return true;
  // In implicit VR: a short value, and the next element of the same group or file meta information.
  const std::size_t length = byte(4) | byte(5) << 8;
  if (byte(0) != 8 || byte(6) != 0 || byte(7) != 0 || length > 128 || 8 + length + 4 > bytes.size())
    return false;
  return byte(8 + length) == 8 && byte(9 + length) == 0 && byte(10 + length) > byte(2);
}

Result<DicomHeader> read_dicom_header(DicomSource& source) {
  DicomHeader header;
  header.path = source.name();
  GVX_TRY(Parser(source, header).parse());
  return header;
}

}  // namespace gvx::io
