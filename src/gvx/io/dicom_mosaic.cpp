#include "gvx/io/dicom_mosaic.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>
#include <vector>

#include "gvx/io/dicom_tags.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr DicomTag kPrivateHeaders[] = {0x00291010, 0x00291110, 0x00291210};
constexpr std::uint32_t kMostFields = 128, kMostValues = 1024;

/// Walks over a private header: little-endian numbers of 32 bits, and texts.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : bytes_(bytes) {}

  std::optional<std::uint32_t> number() {
    if (bytes_.size() < 4) return std::nullopt;
    std::uint32_t value = 0;
    for (int i = 3; i >= 0; --i)
      value = value << 8 | static_cast<unsigned char>(bytes_[static_cast<std::size_t>(i)]);
    bytes_.remove_prefix(4);
    return value;
  }

  std::optional<std::string_view> text(std::size_t length) {
    if (bytes_.size() < length) return std::nullopt;
    const std::string_view value = bytes_.substr(0, length);
    bytes_.remove_prefix(length);
    return value.substr(0, value.find('\0'));
  }

 private:
  std::string_view bytes_;
};

/// The values of one field; empty where it is absent or the header is broken.
std::vector<double> field_of(std::string_view header, std::string_view wanted) {
  Cursor cursor(header);
  const bool second_version = header.starts_with("SV10");
  if (second_version) (void)cursor.text(8);
  const std::optional<std::uint32_t> fields = cursor.number();
  if (!fields || *fields > kMostFields || !cursor.number()) return {};
  std::optional<std::uint32_t> first_count;
  for (std::uint32_t field = 0; field < *fields; ++field) {
    const auto name = cursor.text(64);
    (void)cursor.number();  // value multiplicity
    (void)cursor.text(4);
    (void)cursor.number();
    const auto count = cursor.number();
    if (!name || !count || *count > kMostValues || !cursor.number()) return {};
    if (!first_count) first_count = *count;
    std::vector<double> values;
    for (std::uint32_t i = 0; i < *count; ++i) {
      const auto length_1 = cursor.number(), length_2 = cursor.number();
      (void)cursor.number();
      if (!length_1 || !length_2 || !cursor.number()) return {};
      // The first version adds the first field's number of values to a length.
      const std::uint32_t length = second_version ? *length_2 : *length_1 - *first_count;
      if (length > (1u << 20)) return {};
      const auto text = cursor.text(length);
      if (!text || !cursor.text((4 - length % 4) % 4)) return {};
      if (const auto value = parse_number(trimmed(*text))) values.push_back(*value);
    }
    if (*name == wanted) return values;
  }
  return {};
}

}  // namespace

std::optional<DicomMosaic> find_mosaic(const DicomDataset& elements) {
  if (elements.text(tag::kImageType).find("MOSAIC") == std::string::npos) return std::nullopt;
  DicomMosaic mosaic;
  mosaic.tiles = elements.count(tag::kMosaicImages).value_or(0);
  for (const DicomTag tag : kPrivateHeaders) {
    const DicomElement* const element = elements.find(tag);
    if (element == nullptr) continue;
    const std::vector<double> count = field_of(element->value, "NumberOfImagesInMosaic");
    if (mosaic.tiles == 0 && !count.empty() && count[0] >= 1 && count[0] <= 65536) {
      mosaic.tiles = static_cast<std::int64_t>(count[0]);
    }
    const std::vector<double> normal = field_of(element->value, "SliceNormalVector");
    if (!mosaic.normal && normal.size() == 3) mosaic.normal = Vec3d(normal[0], normal[1], normal[2]);
  }
  return mosaic.tiles > 0 ? std::optional(mosaic) : std::nullopt;
}

}  // namespace gvx::io
