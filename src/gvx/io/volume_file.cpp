#include "gvx/io/volume_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <type_traits>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::int64_t kLongestAxis = std::numeric_limits<std::int32_t>::max();
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 62;

/// A number's place in a pattern: %, a 0 that fills with zeros, a least width, and d.
struct NumberPlace {
  std::size_t begin = 0, end = 0;
  bool zeros = false;
  std::size_t width = 0;
};

std::optional<NumberPlace> next_number_place(std::string_view pattern, std::size_t from) {
  constexpr std::size_t kWidest = 20;
  for (std::size_t begin = pattern.find('%', from); begin != std::string_view::npos;
       begin = pattern.find('%', begin + 1)) {
    std::size_t at = begin + 1;
    NumberPlace place{.begin = begin, .zeros = pattern.substr(at).starts_with('0')};
    while (at < pattern.size() && pattern[at] >= '0' && pattern[at] <= '9') {
      place.width = std::min(10 * place.width + static_cast<std::size_t>(pattern[at++] - '0'), kWidest);
    }
    if (at == pattern.size() || (pattern[at] != 'd' && pattern[at] != 'i' && pattern[at] != 'u')) continue;
    place.end = at + 1;
    return place;
  }
  return std::nullopt;
}

std::string written(std::int64_t number, const NumberPlace& place) {
  const std::string sign = number < 0 ? "-" : "", digits = std::to_string(std::abs(number));
  const std::size_t length = sign.size() + digits.size();
  const std::string fill(place.width > length ? place.width - length : 0, place.zeros ? '0' : ' ');
  return place.zeros ? sign + fill + digits : fill + sign + digits;
}

bool finite(Vec3d v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// The largest number that a sample can be, without its sign; 1 for floating point.
double largest_sample(SampleType type) {
  double most = 1;
  with_sample_type(type, [&](auto sample) {
    using Sample = decltype(sample);
    if (std::is_integral_v<Sample>) most = static_cast<double>(std::numeric_limits<Sample>::max());
  });
  return most;
}

/// Of the lengths of voxels along an axis.
constexpr double kLeastSpacing = 1e-12, kMostSpacing = 1e12;
constexpr double kFarthestOrigin = 1e20;

Status check_place(const VolumeDescription& description) {
  const auto wrong = [&](const std::string& what) { return file_error(description.path, what); };
  const Affine3& a = description.voxel_to_world;
  if (!finite(a.column[0]) || !finite(a.column[1]) || !finite(a.column[2]) || !finite(a.origin))
    return wrong("orientation: expected a finite origin and three finite axes that span a volume");
  Vec3d spacing;
  for (int axis = 0; axis < 3; ++axis) {
    // Not length(): its square may be too large for a number.
    spacing[axis] = std::hypot(a.column[axis].x, a.column[axis].y, a.column[axis].z);
    if (!(spacing[axis] >= kLeastSpacing && spacing[axis] <= kMostSpacing)) {
      return wrong("spacing: expected 1e-12 to 1e12 along each axis, found " + number_text(spacing[axis]) +
                   " along " + "xyz"[axis]);
    }
    if (std::abs(a.origin[axis]) > kFarthestOrigin)
      return wrong("origin: expected coordinates up to 1e20, found " + number_text(a.origin[axis]));
  }
  if (check_placement(a).ok()) return {};
  const double least = std::min({spacing.x, spacing.y, spacing.z});
  const double most = std::max({spacing.x, spacing.y, spacing.z});
  if (most > 1e6 * least) {
    return wrong("spacing: expected no axis with more than a million times the spacing of another, found " +
                 number_text(spacing.x) + " x " + number_text(spacing.y) + " x " + number_text(spacing.z));
  }
  return wrong("orientation: expected three axes that span a volume");
}

}  // namespace

std::uint64_t slice_bytes(const VolumeDescription& description) {
  return static_cast<std::uint64_t>(description.dimensions.x) *
         static_cast<std::uint64_t>(description.dimensions.y) * sample_bytes(description.type) *
         static_cast<std::uint64_t>(description.components);
}

std::uint64_t volume_bytes(const VolumeDescription& description) {
  return slice_bytes(description) * static_cast<std::uint64_t>(description.dimensions.z);
}

bool is_file_pattern(std::string_view name) {
  return next_number_place(name, 0).has_value();
}

std::optional<std::vector<std::string>> names_of_pattern(std::string_view pattern, std::int64_t first,
                                                         std::int64_t last, std::int64_t step) {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 53;
  const std::optional<NumberPlace> place = next_number_place(pattern, 0);
  if (!place || next_number_place(pattern, place->end)) return std::nullopt;
  for (const std::int64_t number : {first, last, step}) {
    if (number < -kFarthest || number > kFarthest) return std::nullopt;
  }
  if (step == 0 || (last != first && (step > 0) != (last > first))) return std::nullopt;
  const std::int64_t count = (last - first) / step + 1;
  if (count > kMostDataFiles) return std::nullopt;
  std::vector<std::string> names;
  for (std::int64_t i = 0; i < count; ++i) {
    names.push_back(std::string(pattern.substr(0, place->begin)) + written(first + i * step, *place) +
                    std::string(pattern.substr(place->end)));
  }
  return names;
}

std::vector<std::string> listed_names(std::string_view lines) {
  std::vector<std::string> names;
  while (!lines.empty()) {
    const std::string_view name = trimmed(take_line(lines));
    if (name.empty()) break;
    names.emplace_back(name);
  }
  return names;
}

Status set_data_files(VolumeFile& file, const char* field, const std::vector<std::string>& names,
                      const std::vector<std::int64_t>& sizes, std::int64_t axes_in_file) {
  const auto wrong = [&](const std::string& expected, std::int64_t found) {
    return file_error(file.header_path,
                      std::string(field) + ": expected " + expected + ", found " + std::to_string(found));
  };
  const auto axes = static_cast<std::int64_t>(sizes.size());
  if (axes_in_file < 1 || axes_in_file > axes) {
    return wrong("files of 1 to " + std::to_string(axes) + " axes", axes_in_file);
  }
  const auto count = static_cast<std::int64_t>(names.size());
  if (count > kMostDataFiles) return wrong("at most " + std::to_string(kMostDataFiles) + " files", count);
  std::int64_t places = 1;
  for (std::int64_t axis = axes_in_file; axis < axes; ++axis) {
    // More than kMostDataFiles, which no size may be, is as good as any such number.
    const std::int64_t size = std::min(sizes[static_cast<std::size_t>(axis)], kMostDataFiles + 1);
    places = std::min(places * size, kMostDataFiles + 1);
  }
  if (axes_in_file < axes && count != places) {
    return wrong((places > kMostDataFiles ? "more than " : "") +
                     std::to_string(std::min(places, kMostDataFiles)) + " files for these sizes",
                 count);
  }
  if (axes_in_file == axes && (count == 0 || sizes.back() % count != 0)) {
    return wrong("files that share the last axis of " + std::to_string(sizes.back()) + " evenly", count);
  }
  for (const std::string& name : names) file.data_paths.push_back(beside(file.header_path, name));
  return {};
}

Status check_description(const VolumeDescription& description) {
  if (description.components < 1 || description.components > 4) {
    return file_error(description.path, "components: expected 1 to 4 numbers a voxel, found " +
                                            std::to_string(description.components));
  }
  std::uint64_t bytes = sample_bytes(description.type) * static_cast<std::uint64_t>(description.components);
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t length = description.dimensions[axis];
    if (length < 1 || length > kLongestAxis) {
      return file_error(description.path, "dimensions: expected 1 to 2147483647 voxels an axis, found " +
                                              std::to_string(length));
    }
    if (bytes > kMostBytes / static_cast<std::uint64_t>(length)) {
      return file_error(description.path, "dimensions: expected less than 2^62 bytes in all");
    }
    bytes *= static_cast<std::uint64_t>(length);
  }
  if (bytes == kMostBytes) {
    return file_error(description.path, "dimensions: expected less than 2^62 bytes in all");
  }
  GVX_TRY(check_place(description));
  if (!std::isfinite(description.scale) || description.scale == 0 || !std::isfinite(description.offset)) {
    return file_error(description.path,
                      "value scale: expected a finite offset and a finite slope other than 0");
  }
  const double most =
      std::abs(description.scale) * largest_sample(description.type) + std::abs(description.offset);
  if (!(most <= std::numeric_limits<float>::max())) {
    return file_error(description.path,
                      "value scale: expected values that fit 32-bit floating point, found a slope of " +
                          number_text(description.scale) + " and an offset of " +
                          number_text(description.offset));
  }
  return {};
}

Affine3 from_index_to_centre(const Affine3& index_to_world) {
  Affine3 shifted = index_to_world;
  shifted.origin = index_to_world.point(Vec3d(-0.5));
  return shifted;
}

Affine3 with_spacing(const Affine3& voxel_to_world, Vec3d spacing) {
  Affine3 spaced;
  for (int axis = 0; axis < 3; ++axis)
    spaced.column[axis] = spacing[axis] * normalize(voxel_to_world.column[axis]);
  spaced.origin = voxel_to_world.point(Vec3d(0.5)) - spaced.vector(Vec3d(0.5));
  return spaced;
}

Affine3 with_world_scaled(const Affine3& voxel_to_world, Vec3d factors) {
  return scaling(factors) * voxel_to_world;
}

}  // namespace gvx::io
