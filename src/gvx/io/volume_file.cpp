#include "gvx/io/volume_file.h"

#include <cmath>
#include <limits>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::int64_t kLongestAxis = std::numeric_limits<std::int32_t>::max();
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 62;

bool finite(Vec3d v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
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
  const Affine3& a = description.voxel_to_world;
  if (!finite(a.column[0]) || !finite(a.column[1]) || !finite(a.column[2]) || !finite(a.origin) ||
      !std::isnormal(determinant(a))) {
    return file_error(description.path,
                      "orientation: expected a finite origin and three finite axes that span a volume");
  }
  if (!std::isfinite(description.scale) || description.scale == 0 || !std::isfinite(description.offset)) {
    return file_error(description.path,
                      "value scale: expected a finite offset and a finite slope other than 0");
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
