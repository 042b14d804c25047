/// \file
/// Raw samples without a header: what the caller says about them, and what their file's name tells.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/io/volume_file.h"

namespace gvx::io {

/// What a person knows about a raw file; whatever is missing comes from the file's name.
struct RawOptions {
  std::optional<Vec3i> dimensions = {};  ///< Voxels along x, y and z.
  std::optional<SampleType> type = {};
  std::optional<bool> big_endian = {};      ///< Little-endian where neither this nor the name tells.
  std::optional<std::int64_t> offset = {};  ///< Bytes (decoded ones, if packed) before the first sample.
  std::optional<Vec3d> spacing = {};        ///< Size of a voxel along x, y and z; (1, 1, 1) if not given.
  std::optional<int> components = {};       ///< Samples a voxel, side by side; 1 if not given.
};

/// Takes what `options` lack from names such as "engine_256x256x128_uint8.raw" or
/// "walnut_128x96x114_int16_be.raw"; .gz and .bz2 at the end mean packed samples. The corner of voxel (0, 0,
/// 0) is the world's origin. Unless an offset is given, a file of another size than the samples need will not
/// open.
Result<VolumeFile> describe_raw(const std::string& path, const RawOptions& options);

/// Fails unless each component is finite and greater than 0.
Status check_spacing(const std::string& path, Vec3d spacing);

}  // namespace gvx::io
