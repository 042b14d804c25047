#include "gvx/io/nrrd_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

struct Axis {
  std::int64_t size = 1;
  double spacing = 1;
  std::optional<Vec3d> direction;
  bool spatial = true;
  bool colors = false;
};

const std::string* find(const NrrdFields& fields, const char* name) {
  const auto found = fields.find(name);
  return found == fields.end() ? nullptr : &found->second;
}

/// A "(x,y,z)" or "(x,y)"; nothing where it is neither.
std::optional<Vec3d> parse_vector(std::string_view text) {
  text = trimmed(text);
  if (text.size() < 2 || text.front() != '(' || text.back() != ')') return std::nullopt;
  std::string numbers(text.substr(1, text.size() - 2));
  std::replace(numbers.begin(), numbers.end(), ',', ' ');
  const auto components = parse_numbers(numbers);
  if (!components || components->size() < 2 || components->size() > 3) return std::nullopt;
  return Vec3d((*components)[0], (*components)[1], components->size() == 3 ? (*components)[2] : 0);
}

/// One entry an axis of `space directions`: a vector, or nothing for "none"; false where it is malformed.
bool parse_directions(std::string_view text, std::vector<Axis>& axes) {
  for (Axis& axis : axes) {
    text = trimmed(text);
    if (text.starts_with("none")) {
      text.remove_prefix(4);
      axis.spatial = false;
      continue;
    }
    const std::size_t end = text.find(')');
    if (end == std::string_view::npos) return false;
    const std::optional<Vec3d> direction = parse_vector(text.substr(0, end + 1));
    if (!direction) return false;
    text.remove_prefix(end + 1);
    // A vector of NaNs is how some writers say "none".
    if (std::isnan(direction->x) && std::isnan(direction->y)) {
      axis.spatial = false;
    } else {
      axis.direction = direction;
    }
  }
  return trimmed(text).empty();
}

bool is_spatial_kind(std::string_view kind) {
  constexpr std::array<std::string_view, 5> kSpatial = {"domain", "space", "time", "none", "???"};
  return std::find(kSpatial.begin(), kSpatial.end(), kind) != kSpatial.end();
}

Result<std::vector<Axis>> parse_axes(const NrrdFields& fields, const std::string& path) {
  constexpr std::int64_t kMostAxes = 16;
  const std::string* dimension = find(fields, "dimension");
  const std::string* sizes = find(fields, "sizes");
  if (dimension == nullptr) return file_error(path, "dimension: expected this field");
  if (sizes == nullptr) return file_error(path, "sizes: expected this field");
  const auto count = parse_integer(*dimension);
  if (!count || *count < 1 || *count > kMostAxes) {
    return file_error(path, "dimension: expected 1 to 16, found " + quoted(*dimension));
  }
  std::vector<Axis> axes(static_cast<std::size_t>(*count));
  const std::vector<std::string_view> lengths = words(*sizes);
  if (lengths.size() != axes.size()) {
    return file_error(path, "sizes: expected " + *dimension + " numbers, found " + quoted(*sizes));
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto length = parse_integer(lengths[i]);
    if (!length || *length < 1)
      return file_error(path, "sizes: expected numbers from 1, found " + quoted(*sizes));
    axes[i].size = *length;
  }
  if (const std::string* spacings = find(fields, "spacings")) {
    const auto numbers = parse_numbers(*spacings);
    if (!numbers || numbers->size() != axes.size()) {
      return file_error(path, "spacings: expected " + *dimension + " numbers, found " + quoted(*spacings));
    }
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const double spacing = (*numbers)[i];
      if (std::isinf(spacing) || spacing == 0) {
        return file_error(path, "spacings: expected finite numbers other than 0, found " + quoted(*spacings));
      }
      axes[i].spacing = std::isnan(spacing) ? 1 : spacing;  // NaN is the format's "unknown"
    }
  }
  if (const std::string* directions = find(fields, "space directions")) {
    if (!parse_directions(*directions, axes)) {
      return file_error(path, "space directions: expected a vector such as (1,0,0) or none for each of " +
                                  *dimension + " axes, found " + quoted(*directions));
    }
  }
  if (const std::string* kinds = find(fields, "kinds")) {
    const std::vector<std::string_view> names = words(*kinds);
    if (names.size() != axes.size()) {
      return file_error(path, "kinds: expected " + *dimension + " words, found " + quoted(*kinds));
    }
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const std::string kind = lower_case(names[i]);
      if (!is_spatial_kind(kind)) axes[i].spatial = false;
      axes[i].colors = kind == "rgb-color" || kind == "rgba-color" || kind == "3-color" || kind == "4-color";
    }
  }
  return axes;
}

/// Takes a first axis of two to four numbers a voxel for the voxels' components.
void take_components(std::vector<Axis>& axes, VolumeDescription& description) {
  const Axis& first = axes.front();
  if (first.spatial || first.size < 2 || first.size > 4) return;
  description.components = static_cast<int>(first.size);
  description.colors = first.colors && first.size >= 3;
  axes.erase(axes.begin());
}

Status keep_three_axes(const std::string& path, std::vector<Axis>& axes) {
  const std::size_t stated = axes.size();
  for (const Axis& axis : axes) {
    if (!axis.spatial && axis.size > 1) {
      return file_error(path,
                        "kinds: expected one to four numbers a voxel, in the first axis, found an axis of " +
                            std::to_string(axis.size) + " vector components or the like");
    }
  }
  std::erase_if(axes, [](const Axis& axis) { return !axis.spatial; });
  if (axes.size() == 4) {
    const auto single = [](const Axis& axis) { return axis.size == 1; };
    if (std::count_if(axes.begin(), axes.end(), single) == 1) std::erase_if(axes, single);
  }
  if (axes.size() == 2) axes.emplace_back();
  if (axes.size() != 3) {
    return file_error(
        path, "dimension: expected one volume of 3 axes (or 2, or 4 of which one has the length 1), found " +
                  std::to_string(stated) + " axes");
  }
  return {};
}

/// The signs that take an axis of the named space to RAS+; nothing for spaces that are not a patient's.
std::optional<Vec3d> signs_to_ras(std::string_view space) {
  if (space == "right-anterior-superior" || space == "ras") return Vec3d(1, 1, 1);
  if (space == "left-anterior-superior" || space == "las") return Vec3d(-1, 1, 1);
  if (space == "left-posterior-superior" || space == "lps") return Vec3d(-1, -1, 1);
  return std::nullopt;
}

/// Of the first unit in `units`, such as "mm" "mm" "mm" with the quotation marks; 1 where it is not known.
double millimetres_per_unit(const std::string& units) {
  const std::size_t open = units.find('"');
  const std::string unit =
      open == std::string::npos ? "" : units.substr(open + 1, units.find('"', open + 1) - open - 1);
  if (unit == "m") return 1000;
  if (unit == "cm") return 10;
  if (unit == "um" || unit == "microns" || unit == "\xc2\xb5m") return 1e-3;
  if (unit == "nm") return 1e-6;
  return 1;
}

}  // namespace

Status interpret_nrrd_axes(const NrrdFields& fields, VolumeDescription& description) {
  const std::string& path = description.path;
  GVX_ASSIGN(std::vector<Axis> axes, parse_axes(fields, path));
  take_components(axes, description);
  GVX_TRY(keep_three_axes(path, axes));
  description.dimensions = {axes[0].size, axes[1].size, axes[2].size};

  const bool oriented = axes[0].direction && axes[1].direction;
  if (oriented && !axes[2].direction) {
    const Vec3d normal = cross(*axes[0].direction, *axes[1].direction);
    axes[2].direction = normal == Vec3d(0.0) ? normal : normalize(normal);
  }
  Affine3 index_to_world;
  for (int i = 0; i < 3; ++i) {
    const Axis& axis = axes[static_cast<std::size_t>(i)];
    if (oriented) {
      index_to_world.column[i] = *axis.direction;
    } else {
      index_to_world.column[i] = axis.spacing * index_to_world.column[i];
    }
  }
  description.voxel_to_world = index_to_world;
  if (const std::string* origin = find(fields, "space origin")) {
    const std::optional<Vec3d> centre = parse_vector(*origin);
    if (!centre)
      return file_error(path, "space origin: expected a vector such as (0,0,0), found " + quoted(*origin));
    index_to_world.origin = *centre;
    description.voxel_to_world = from_index_to_centre(index_to_world);
  }
  const std::string* space = find(fields, "space");
  const auto signs = space != nullptr && oriented ? signs_to_ras(lower_case(*space)) : std::nullopt;
  if (signs) {
    const std::string* units = find(fields, "space units");
    const double unit = units != nullptr ? millimetres_per_unit(*units) : 1;
    description.voxel_to_world = with_world_scaled(description.voxel_to_world, unit * *signs);
    description.anatomical = true;
  }
  return {};
}

}  // namespace gvx::io
