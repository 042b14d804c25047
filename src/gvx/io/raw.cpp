#include "gvx/io/raw.h"

#include <cmath>
#include <string_view>
#include <vector>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

std::vector<std::string_view> split(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> parts;
  while (!text.empty()) {
    const std::size_t end = text.find_first_of(separators);
    if (end != 0) parts.push_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return parts;
}

std::optional<Vec3i> parse_dimensions(std::string_view text) {
  const std::vector<std::string_view> lengths = split(text, "x");
  if (lengths.size() != 3) return std::nullopt;
  Vec3i dimensions;
  for (int axis = 0; axis < 3; ++axis) {
    const auto length = parse_integer(lengths[static_cast<std::size_t>(axis)]);
    if (!length) return std::nullopt;
    dimensions[axis] = *length;
  }
  return dimensions;
}

std::optional<bool> parse_byte_order(std::string_view text) {
  if (text == "be" || text == "msb" || text == "bigendian") return true;
  if (text == "le" || text == "lsb" || text == "littleendian") return false;
  return std::nullopt;
}

RawOptions with_hints_from_name(RawOptions options, const std::string& path) {
  const std::string name = lower_case(std::string_view(path).substr(path.find_last_of('/') + 1));
  RawOptions hints;
  for (const std::string_view part : split(name, "_-. ")) {
    if (!hints.dimensions) hints.dimensions = parse_dimensions(part);
    if (!hints.type) hints.type = parse_sample_type(part);
    if (!hints.big_endian) hints.big_endian = parse_byte_order(part);
  }
  if (!options.dimensions) options.dimensions = hints.dimensions;
  if (!options.type) options.type = hints.type;
  if (!options.big_endian) options.big_endian = hints.big_endian;
  return options;
}

}  // namespace

Status check_spacing(const std::string& path, Vec3d spacing) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(spacing[axis]) || spacing[axis] <= 0) {
      return file_error(path, "spacing: expected three finite numbers greater than 0");
    }
  }
  return {};
}

Result<VolumeFile> describe_raw(const std::string& path, const RawOptions& given) {
  const RawOptions options = with_hints_from_name(given, path);
  if (!options.dimensions) {
    return file_error(path,
                      "dimensions: expected in the name, as in engine_256x256x128_uint8.raw, or given "
                      "(--dims 256,256,128)");
  }
  if (!options.type) {
    return file_error(path,
                      std::string("type: expected in the name, as in engine_256x256x128_uint8.raw, or given "
                                  "(--dtype, one of ") +
                          kSampleTypeNames + ")");
  }
  const std::int64_t offset = options.offset.value_or(0);
  if (offset < 0) {
    return file_error(path, "offset: expected 0 or more bytes, found " + std::to_string(offset));
  }
  VolumeFile file;
  file.description.path = path;
  file.description.dimensions = *options.dimensions;
  file.description.type = *options.type;
  file.description.components = options.components.value_or(1);
  file.description.big_endian = options.big_endian.value_or(false);
  if (options.spacing) {
    GVX_TRY(check_spacing(path, *options.spacing));
    file.description.voxel_to_world = scaling(*options.spacing);
  }
  file.data_paths = {path};
  const std::string name = lower_case(path);
  if (name.ends_with(".gz")) file.encoding = Encoding::gzip;
  if (name.ends_with(".bz2")) file.encoding = Encoding::bzip2;
  file.byte_skip = offset;
  file.exact_size = !options.offset;
  return file;
}

}  // namespace gvx::io
