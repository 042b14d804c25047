/// \file
/// What the header of a volume file says: the volume's shape, numbers and place (VolumeDescription), and
/// where and how its samples are stored (VolumeFile). Every format's parser returns a VolumeFile;
/// VolumeReader reads any of them.
///
///     data file:  | file_offset bytes | line_skip lines | encoded samples ...
///     decoded:                                          | byte_skip bytes | x fastest, then y, then z |
///     ignored
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/io/byte_stream.h"
#include "gvx/io/sample_type.h"

namespace gvx::io {

/// What a file says of one of its channels.
struct ChannelDescription {
  std::string name;            ///< Empty where the file has none.
  std::optional<Vec3f> color;  ///< In which it is shown: red, green, blue from 0 to 1.
};

/// One of several series of images that a folder holds.
struct SeriesDescription {
  std::string number;  ///< By which --series chooses it.
  std::string uid;
  std::string description;
  std::string modality;
  Vec3i dimensions;
  std::int64_t frames = 1;
};

/// A volume as its file states it. Voxel (i, j, k) covers the unit cube [i, i+1) x [j, j+1) x [k, k+1) of
/// voxel space, so its centre is at (i+0.5, j+0.5, k+0.5).
struct VolumeDescription {
  std::string path;  ///< The file that was asked for; messages name it.
  Vec3i dimensions;  ///< Voxels along x, y and z, each from 1 to 2^31-1.
  SampleType type = SampleType::u8;
  int components = 1;       ///< Samples a voxel, 1 to 4, side by side.
  bool colors = false;      ///< They are red, green, blue and, if there are four, opacity.
  bool labels = false;      ///< They name classes, each an integer.
  bool big_endian = false;  ///< In the file; readers hand out native byte order.
  Affine3 voxel_to_world;   ///< From voxel space to world space, in the file's units unless anatomical.
  bool anatomical =
      false;         ///< World space is a patient: x to the right, y to the front, z up, in millimetres.
  std::string unit;  ///< Of lengths in world space, as the file writes it, such as "mm"; empty: not known.
  double scale = 1;  ///< Physical value = scale * stored sample + offset.
  double offset = 0;
  std::int64_t frames = 1;  ///< Points in time that the file has; the volume is one of them.
  std::int64_t frame = 0;
  std::vector<ChannelDescription> channels = {};  ///< One a component, or none.
  /// What a person should know, a line each: slices that are tilted, uneven or missing, what is not used.
  std::vector<std::string> remarks = {};
  std::vector<SeriesDescription> series =
      {};  ///< Of a folder that holds several, the volume's own among them.
};

/// As VolumeFile::byte_skip: the samples are the last of the decoded bytes.
inline constexpr std::int64_t kSamplesAtEnd = -1;

/// A volume and where its samples are.
struct VolumeFile {
  VolumeDescription description;
  std::string header_path;  ///< Of the file that was parsed; empty for raw samples, which have no header.
  /// Files that hold equal shares of the samples, one after the other, each laid out as drawn above. "-" is
  /// standard input.
  std::vector<std::string> data_paths;
  Encoding encoding = Encoding::raw;
  StreamStart start;
  std::int64_t byte_skip = 0;  ///< Decoded bytes before the first sample of a file, or kSamplesAtEnd.
  /// Behind the samples, of other volumes: other points in time, other components. They must be there.
  std::uint64_t bytes_behind = 0;
  /// Components that lie in volumes of their own, and the bytes from one to the next. The description and
  /// bytes_behind are those of the first alone.
  int planes = 1;
  std::uint64_t plane_bytes = 0;
  bool exact_size = false;  ///< Bytes behind the last sample are an error where the file's size shows them.
};

/// The bytes of one z-slice; the description must have passed check_description().
std::uint64_t slice_bytes(const VolumeDescription& description);

/// The bytes of all samples; the description must have passed check_description().
std::uint64_t volume_bytes(const VolumeDescription& description);

/// No header may name more data files.
inline constexpr std::int64_t kMostDataFiles = std::int64_t{1} << 18;

/// Does the name hold a number's place, such as the %03d of "slice%03d.raw"?
bool is_file_pattern(std::string_view name);

/// The names of a pattern such as "slice%03d.raw" with the numbers from `first` to `last` in steps of `step`,
/// which may be below 0; nothing where the pattern has not exactly one number's place, or where the numbers
/// are none or more than kMostDataFiles.
std::optional<std::vector<std::string>> names_of_pattern(std::string_view pattern, std::int64_t first,
                                                         std::int64_t last, std::int64_t step);

/// The lines up to the first empty one.
std::vector<std::string> listed_names(std::string_view lines);

/// Sets the file's data_paths: the names, beside the header. `sizes` are those of the header's axes, fastest
/// first, and each data file holds the first `axes_in_file` of them. An error of the field where there are
/// not as many names as places along the other axes; names of files that hold all axes share out the last.
Status set_data_files(VolumeFile& file, const char* field, const std::vector<std::string>& names,
                      const std::vector<std::int64_t>& sizes, std::int64_t axes_in_file);

/// Fails unless every dimension is 1 to 2^31-1, all samples together are less than 2^62 bytes, voxel_to_world
/// has an inverse and columns of 1e-12 to 1e12, none a million times as long as another, and scale and offset
/// are finite, scale not zero, and keep the values of integer samples within 32-bit floating point.
Status check_description(const VolumeDescription& description);

/// The same map with voxel (0, 0, 0)'s centre where `index_to_world` puts index (0, 0, 0): most formats'
/// matrices take indices to centres.
Affine3 from_index_to_centre(const Affine3& index_to_world);

/// Changes the lengths of the columns to `spacing`; voxel (0, 0, 0)'s centre stays.
Affine3 with_spacing(const Affine3& voxel_to_world, Vec3d spacing);

/// Multiplies the world's axes by the factors: flips axes, changes units.
Affine3 with_world_scaled(const Affine3& voxel_to_world, Vec3d factors);

}  // namespace gvx::io
