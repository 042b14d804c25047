#include "gvx/io/nifti.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include "gvx/io/header_text.h"
#include "gvx/io/nifti_header.h"

namespace gvx::io {
namespace {

/// The files of a volume: one twice for a single file.
struct FilePair {
  std::string header_path;
  std::string data_path;
};

bool exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

/// `path` with its extension .hdr or .img (before a .gz) replaced, in the same case.
std::string with_extension(const std::string& path, const char* small, const char* capital) {
  const std::size_t dot =
      lower_case(path).ends_with(".gz") ? path.rfind('.', path.size() - 4) : path.rfind('.');
  const bool is_capital = path[dot + 1] >= 'A' && path[dot + 1] <= 'Z';
  return path.substr(0, dot) + (is_capital ? capital : small);
}

std::string existing_partner(const std::string& path, const char* small, const char* capital) {
  const std::string plain = with_extension(path, small, capital);
  return !exists(plain) && exists(plain + ".gz") ? plain + ".gz" : plain;
}

FilePair find_files(const std::string& path) {
  const std::string name = lower_case(path);
  if (name.ends_with(".img") || name.ends_with(".img.gz"))
    return {existing_partner(path, ".hdr", ".HDR"), path};
  if (name.ends_with(".hdr") || name.ends_with(".hdr.gz"))
    return {path, existing_partner(path, ".img", ".IMG")};
  return {path, path};
}

/// RGB and RGBA voxels, of bytes: how many, or 0.
int color_components(int code) {
  return code == 128 ? 3 : code == 2304 ? 4 : 0;
}

Result<SampleType> parse_datatype(const std::string& path, int code) {
  if (color_components(code) > 0) return SampleType::u8;
  switch (code) {
    case 2:
      return SampleType::u8;
    case 4:
      return SampleType::i16;
    case 8:
      return SampleType::i32;
    case 16:
      return SampleType::f32;
    case 64:
      return SampleType::f64;
    case 256:
      return SampleType::i8;
    case 512:
      return SampleType::u16;
    case 768:
      return SampleType::u32;
    case 1024:
      return SampleType::i64;
    case 1280:
      return SampleType::u64;
    default:
      break;
  }
  const char* meaning = code == 32 || code == 1792 || code == 2048 ? " (complex numbers)"
                        : code == 1536                             ? " (numbers of 128 bits)"
                                                                   : "";
  return file_error(path, std::string("datatype: expected ") + kSampleTypeNames + ", found code " +
                              std::to_string(code) + meaning);
}

Status interpret_dimensions(const NiftiHeader& header, VolumeDescription& description) {
  const std::string& path = description.path;
  const std::int64_t count = header.dim[0];
  if (count < 2 || count > 7)
    return file_error(path, "dim[0]: expected 2 to 7, found " + std::to_string(count));
  if (header.dim[1] < 1)
    return file_error(path, "dim[1]: expected 1 or more, found " + std::to_string(header.dim[1]));
  description.dimensions = {1, 1, 1};
  for (std::size_t i = 1; i <= static_cast<std::size_t>(count); ++i) {
    // As nifti1_io.c takes them: files in the wild have 0 for axes that they do not use.
    const std::int64_t length = std::max<std::int64_t>(header.dim[i], 1);
    if (i <= 3) {
      description.dimensions[static_cast<int>(i) - 1] = length;
    } else if (i == 4) {
      description.frames = length;
    } else if (length > (i == 5 ? 4 : 1)) {
      return file_error(path, "dim[" + std::to_string(i) + "]: expected " +
                                  (i == 5 ? "1 to 4 numbers a voxel" : "1") + ", found " +
                                  std::to_string(length));
    }
  }
  return {};
}

/// Which of the volumes in the file are read: one point in time, and all numbers of a vector. A vector's
/// numbers lie further apart than points in time.
Status choose_volumes(const NiftiHeader& header, std::optional<std::int64_t> time, VolumeFile& file) {
  VolumeDescription& d = file.description;
  const std::int64_t numbers = header.dim[0] >= 5 ? std::max<std::int64_t>(header.dim[5], 1) : 1;
  d.frame = time.value_or(0);
  if (d.frame < 0 || d.frame >= d.frames) {
    return file_error(d.path, d.frames == 1
                                  ? "time: the volume does not change with time"
                                  : "time: expected a frame from 0 to " + std::to_string(d.frames - 1) +
                                        ", found " + std::to_string(d.frame));
  }
  if (d.frames > 1 && !time) {
    d.remarks.push_back("has " + std::to_string(d.frames) +
                        " frames in time; the first is read (--time 0 to " + std::to_string(d.frames - 1) +
                        " chooses one)");
  }
  if (numbers > 1 && d.colors) return file_error(d.path, "dim[5]: expected 1 for colours");
  if (d.frames == 1 && numbers == 1) return {};
  GVX_TRY(check_description(d));
  const std::uint64_t one = volume_bytes(d);
  std::uint64_t all = 0;
  if (__builtin_mul_overflow(one, static_cast<std::uint64_t>(d.frames * numbers), &all) ||
      d.frames > INT64_MAX / numbers || all >= std::uint64_t{1} << 62) {
    return file_error(d.path, "dim: expected less than 2^62 bytes in all");
  }
  file.byte_skip += static_cast<std::int64_t>(one) * d.frame;
  file.bytes_behind = all - one * static_cast<std::uint64_t>(d.frame + 1);
  file.planes = static_cast<int>(numbers);
  file.plane_bytes = one * static_cast<std::uint64_t>(d.frames);
  return {};
}

double millimetres_per_unit(int xyzt_units) {
  switch (xyzt_units & 7) {
    case 1:
      return 1000;
    case 3:
      return 1e-3;
    default:
      return 1;
  }
}

bool usable(const Affine3& a) {
  const auto finite = [](Vec3d v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
  return finite(a.column[0]) && finite(a.column[1]) && finite(a.column[2]) && finite(a.origin) &&
         std::isnormal(determinant(a));
}

/// Method 3 of nifti1.h.
std::optional<Affine3> sform(const NiftiHeader& header) {
  if (header.sform_code <= 0) return std::nullopt;
  Affine3 a;
  for (int row = 0; row < 3; ++row) {
    const std::array<double, 4>& numbers = header.srow[static_cast<std::size_t>(row)];
    for (int axis = 0; axis < 3; ++axis) a.column[axis][row] = numbers[static_cast<std::size_t>(axis)];
    a.origin[row] = numbers[3];
  }
  return usable(a) ? std::optional(a) : std::nullopt;
}

/// Method 2 of nifti1.h: a rotation by the quaternion (a, b, c, d), with pixdim as lengths.
std::optional<Affine3> qform(const NiftiHeader& header, Vec3d spacing) {
  if (header.qform_code <= 0) return std::nullopt;
  auto [b, c, d] = header.quatern;
  double a = 0;
  const double squares = b * b + c * c + d * d;
  if (squares > 1) {
    // Rounding made it longer than a unit quaternion can be: a half turn.
    const double to_unit = 1 / std::sqrt(squares);
    b *= to_unit, c *= to_unit, d *= to_unit;
  } else {
    a = std::sqrt(1 - squares);
  }
  const double handedness = header.pixdim[0] < 0 ? -1 : 1;
  Affine3 m;
  m.column[0] = spacing.x * Vec3d(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c));
  m.column[1] = spacing.y * Vec3d(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b));
  m.column[2] =
      handedness * spacing.z * Vec3d(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - b * b - c * c);
  m.origin = {header.qoffset[0], header.qoffset[1], header.qoffset[2]};
  return usable(m) ? std::optional(m) : std::nullopt;
}

void interpret_place(const NiftiHeader& header, bool analyze, VolumeDescription& description) {
  Vec3d spacing(1.0);
  for (int axis = 0; axis < 3; ++axis) {
    const double stated = std::abs(header.pixdim[static_cast<std::size_t>(axis) + 1]);
    if (std::isfinite(stated) && stated > 0) spacing[axis] = stated;
  }
  const double unit = analyze ? 1 : millimetres_per_unit(header.xyzt_units);
  std::optional<Affine3> index_to_world;
  if (!analyze) {
    index_to_world = sform(header);
    if (!index_to_world) index_to_world = qform(header, spacing);
  }
  description.anatomical = index_to_world.has_value();
  description.voxel_to_world = with_world_scaled(
      index_to_world ? from_index_to_centre(*index_to_world) : scaling(spacing), Vec3d(unit));
}

Status interpret_values(const NiftiHeader& header, VolumeDescription& description) {
  const double slope = header.scl_slope, intercept = header.scl_inter;
  if (slope == 0 || !std::isfinite(slope)) return {};  // as the format says: no scaling
  if (!std::isfinite(intercept)) return file_error(description.path, "scl_inter: expected a finite number");
  description.scale = slope;
  description.offset = intercept;
  return {};
}

/// NIFTI_INTENT_LABEL of nifti1.h, where the numbers can be labels.
bool names_classes(const NiftiHeader& header, const VolumeDescription& description) {
  constexpr int kLabel = 1002;
  return header.intent_code == kLabel && description.components == 1 && description.type != SampleType::f32 &&
         description.type != SampleType::f64 && description.scale == 1 && description.offset == 0;
}

Result<std::int64_t> data_offset(const std::string& path, const NiftiHeader& header) {
  const double stated = header.vox_offset;
  const int least = header.kind == NiftiHeader::Kind::single ? header.least_vox_offset() : 0;
  if (stated == 0) return least;
  if (!(stated >= least && stated <= 1e15) || stated != std::floor(stated)) {
    return file_error(path, "vox_offset: expected a whole number of bytes from " + std::to_string(least));
  }
  return static_cast<std::int64_t>(stated);
}

}  // namespace

Result<VolumeFile> parse_nifti(const std::string& path, std::optional<std::int64_t> time) {
  const FilePair files = find_files(path);
  GVX_ASSIGN(const NiftiHeader header, read_nifti_header(files.header_path));
  const bool single = header.kind == NiftiHeader::Kind::single;
  const bool analyze = header.kind == NiftiHeader::Kind::analyze;
  if (analyze && files.header_path == files.data_path) {
    return file_error(path, "magic: expected n+1 or ni1");
  }
  VolumeFile file;
  file.description.path = path;
  file.description.big_endian = header.big_endian;
  file.header_path = files.header_path;
  file.data_paths = {single ? files.header_path : files.data_path};
  if (!single && files.header_path == files.data_path) {
    const std::string version = std::to_string(header.version);
    return file_error(path, "magic: expected n+" + version +
                                " for a header and its samples in one file, found ni" + version);
  }
  GVX_TRY(interpret_dimensions(header, file.description));
  GVX_ASSIGN(file.description.type, parse_datatype(path, header.datatype));
  if (const int components = color_components(header.datatype); components > 0) {
    file.description.components = components;
    file.description.colors = true;
  }
  interpret_place(header, analyze, file.description);
  if (!analyze) {
    GVX_TRY(interpret_values(header, file.description));
    file.description.labels = names_classes(header, file.description);
  }
  GVX_ASSIGN(file.byte_skip, data_offset(path, header));
  GVX_TRY(choose_volumes(header, time, file));
  GVX_ASSIGN(file.encoding, detect_gzip(file.data_paths.front()));
  return file;
}

}  // namespace gvx::io
