#include "gvx/io/tiff_imagej.h"

#include <cmath>
#include <cstring>

#include "gvx/io/header_text.h"
#include "gvx/io/ome_xml.h"

namespace gvx::io {
namespace {

/// Tag 50839 begins with "IJIJ" and, for each kind of part, four letters and a count; then the parts follow,
/// whose sizes are those of tag 50838 from the second on.
std::vector<Vec3f> lookup_colors(const TiffTags& tags) {
  constexpr std::size_t kTable = 768;  // 256 reds, greens, blues
  const std::vector<std::byte>& bytes = tags.imagej_metadata;
  if (tags.imagej_counts.empty() || tags.imagej_counts.front() > bytes.size()) return {};
  const std::size_t header = tags.imagej_counts.front();
  if (header < 4) return {};
  const bool swapped = std::memcmp(bytes.data(), "JIJI", 4) == 0;
  if (!swapped && std::memcmp(bytes.data(), "IJIJ", 4) != 0) return {};
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + (swapped ? 3 - i : i)]);
    return value;
  };
  std::vector<Vec3f> colors;
  std::size_t part = 1, position = header;
  for (std::size_t at = 4; at + 8 <= header; at += 8) {
    const bool tables = word(at) == 0x6c757473;  // "luts"
    for (std::uint32_t i = word(at + 4); i > 0 && part < tags.imagej_counts.size(); --i) {
      const std::size_t size = tags.imagej_counts[part++];
      if (size > bytes.size() - position) return colors;
      if (tables && size == kTable) {
        const auto last = [&](std::size_t color) {
          return static_cast<float>(std::to_integer<int>(bytes[position + color * 256 + 255])) / 255;
        };
        colors.push_back({last(0), last(1), last(2)});
      }
      position += size;
    }
  }
  return colors;
}

/// The unit of the tag counts where the description has none. 72 pixels an inch are a screen's, and say
/// nothing.
void read_resolution(const TiffTags& tags, ImageJInfo& info) {
  constexpr int kInch = 2, kCentimetre = 3;
  const bool screen = tags.resolution_unit == kInch && tags.resolution[0] == 72.0;
  if (info.unit.empty() && screen) return;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto resolution = tags.resolution[axis];
    if (!resolution || !std::isfinite(*resolution) || *resolution <= 0) continue;
    info.spacing[axis] = 1 / *resolution;
    if (info.unit.empty() && tags.resolution_unit == kInch) info.unit = "inch";
    if (info.unit.empty() && tags.resolution_unit == kCentimetre) info.unit = "cm";
  }
}

}  // namespace

std::optional<ImageJInfo> parse_imagej(const TiffTags& tags) {
  if (!tags.description.starts_with("ImageJ=")) return std::nullopt;
  ImageJInfo info;
  double coefficients[2] = {0, 1};
  bool line = false;
  std::optional<std::int64_t> images, slices;
  std::string_view rest = tags.description;
  while (!rest.empty()) {
    const std::string_view text = take_line(rest);
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string_view key = trimmed(text.substr(0, equals)), value = trimmed(text.substr(equals + 1));
    const auto count = parse_integer(value);
    const bool counted = count && *count >= 1 && *count <= INT32_MAX;
    const auto number = parse_number(value);
    const bool finite = number && std::isfinite(*number);
    if (key == "images" && counted) images = count;
    if (key == "channels" && counted) info.channels = *count;
    if (key == "slices" && counted) slices = count;
    if (key == "frames" && counted) info.frames = *count;
    if (key == "spacing" && finite && *number != 0) info.spacing[2] = std::abs(*number);
    if (key == "xorigin" && finite) info.origin.x = *number;
    if (key == "yorigin" && finite) info.origin.y = *number;
    if (key == "zorigin" && finite) info.origin.z = *number;
    if (key == "unit") info.unit = value;
    if (key == "cf") line = value == "0";
    if (key == "c0" && finite) coefficients[0] = *number;
    if (key == "c1" && finite) coefficients[1] = *number;
  }
  info.slices = slices.value_or(1);
  if (!slices && images && *images % (info.channels * info.frames) == 0)
    info.slices = *images / (info.channels * info.frames);
  info.images = images.value_or(1);
  if (line && coefficients[1] != 0) info.offset = coefficients[0], info.scale = coefficients[1];
  if (info.unit == "pixel" || info.unit == "pixels") info.unit.clear();
  if (!info.unit.empty() && micrometres_of(info.unit) == 1.0) info.unit = "\xC2\xB5m";
  read_resolution(tags, info);
  info.colors = lookup_colors(tags);
  return info;
}

}  // namespace gvx::io
