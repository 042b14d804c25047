#include "gvx/io/nifti.h"

#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include "gvx/io/header_text.h"
#include "gvx/io/nifti_header.h"

namespace gvx::io {
namespace {

constexpr std::int64_t kSingleFileDataOffset = 352;

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
    default:
      break;
  }
  const char* meaning = code == 32 || code == 1792 || code == 2048 ? " (complex numbers)"
                        : code == 1024 || code == 1280 || code == 1536
                            ? " (more than 64 bits, or 64-bit integers)"
                            : "";
  return file_error(path, std::string("datatype: expected ") + kSampleTypeNames + ", found code " +
                              std::to_string(code) + meaning);
}

Status interpret_dimensions(const NiftiHeader& header, VolumeDescription& description) {
  const std::string& path = description.path;
  const int count = header.dim(0);
  if (count < 2 || count > 7)
    return file_error(path, "dim[0]: expected 2 to 7, found " + std::to_string(count));
  description.dimensions = {1, 1, 1};
  std::int64_t volumes = 1;
  for (int i = 1; i <= count; ++i) {
    const int length = header.dim(i);
    if (length < 1) {
      return file_error(
          path, "dim[" + std::to_string(i) + "]: expected 1 or more, found " + std::to_string(length));
    }
    if (i <= 3) {
      description.dimensions[i - 1] = length;
    } else {
      volumes *= length;  // four lengths of 15 bits
    }
  }
  if (volumes == 1) return {};
  return file_error(path, "dim: expected one volume, found " + std::to_string(volumes) + " volumes");
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
  if (header.short_at(254) <= 0) return std::nullopt;
  Affine3 a;
  for (int row = 0; row < 3; ++row) {
    const std::size_t at = 280 + 16 * static_cast<std::size_t>(row);
    for (int axis = 0; axis < 3; ++axis) {
      a.column[axis][row] = header.float_at(at + 4 * static_cast<std::size_t>(axis));
    }
    a.origin[row] = header.float_at(at + 12);
  }
  return usable(a) ? std::optional(a) : std::nullopt;
}

/// Method 2 of nifti1.h: a rotation by the quaternion (a, b, c, d), with pixdim as lengths.
std::optional<Affine3> qform(const NiftiHeader& header, Vec3d spacing) {
  if (header.short_at(252) <= 0) return std::nullopt;
  double b = header.float_at(256), c = header.float_at(260), d = header.float_at(264);
  double a = 0;
  const double squares = b * b + c * c + d * d;
  if (squares > 1) {
    // Rounding made it longer than a unit quaternion can be: a half turn.
    const double to_unit = 1 / std::sqrt(squares);
    b *= to_unit, c *= to_unit, d *= to_unit;
  } else {
    a = std::sqrt(1 - squares);
  }
  const double handedness = header.pixdim(0) < 0 ? -1 : 1;
  Affine3 m;
  m.column[0] = spacing.x * Vec3d(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c));
  m.column[1] = spacing.y * Vec3d(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b));
  m.column[2] =
      handedness * spacing.z * Vec3d(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - b * b - c * c);
  m.origin = {header.float_at(268), header.float_at(272), header.float_at(276)};
  return usable(m) ? std::optional(m) : std::nullopt;
}

void interpret_place(const NiftiHeader& header, bool analyze, VolumeDescription& description) {
  Vec3d spacing(1.0);
  for (int axis = 0; axis < 3; ++axis) {
    const double stated = std::abs(header.pixdim(axis + 1));
    if (std::isfinite(stated) && stated > 0) spacing[axis] = stated;
  }
  const double unit = analyze ? 1 : millimetres_per_unit(std::to_integer<int>(header.bytes[123]));
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
  const double slope = header.float_at(112), intercept = header.float_at(116);
  if (slope == 0 || !std::isfinite(slope)) return {};  // as the format says: no scaling
  if (!std::isfinite(intercept)) return file_error(description.path, "scl_inter: expected a finite number");
  description.scale = slope;
  description.offset = intercept;
  return {};
}

Result<std::int64_t> data_offset(const std::string& path, const NiftiHeader& header, bool single) {
  const double stated = header.float_at(108);
  const double minimum = single ? double{kSingleFileDataOffset} : 0;
  if (single && stated == 0) return kSingleFileDataOffset;
  if (!(stated >= minimum && stated <= 1e15) || stated != std::floor(stated)) {
    return file_error(
        path, "vox_offset: expected a whole number of bytes from " + std::to_string(single ? 352 : 0));
  }
  return static_cast<std::int64_t>(stated);
}

}  // namespace

Result<VolumeFile> parse_nifti(const std::string& path) {
  const FilePair files = find_files(path);
  GVX_ASSIGN(const NiftiHeader header, read_nifti_header(files.header_path));
  const bool single = header.has_magic("n+1");
  const bool pair = header.has_magic("ni1");
  const bool analyze = !single && !pair;
  if (analyze && files.header_path == files.data_path) {
    return file_error(path, "magic: expected n+1 or ni1");
  }
  VolumeFile file;
  file.description.path = path;
  file.description.big_endian = header.big_endian;
  file.header_path = files.header_path;
  file.data_paths = {single ? files.header_path : files.data_path};
  if (pair && files.header_path == files.data_path) {
    return file_error(path, "magic: expected n+1 for a header and its samples in one file, found ni1");
  }
  GVX_TRY(interpret_dimensions(header, file.description));
  const int datatype = header.short_at(70);
  GVX_ASSIGN(file.description.type, parse_datatype(path, datatype));
  if (const int components = color_components(datatype); components > 0) {
    file.description.components = components;
    file.description.colors = true;
  }
  interpret_place(header, analyze, file.description);
  if (!analyze) {
    GVX_TRY(interpret_values(header, file.description));
  }
  GVX_ASSIGN(file.byte_skip, data_offset(path, header, single));
  GVX_ASSIGN(file.encoding, detect_gzip(file.data_paths.front()));
  return file;
}

}  // namespace gvx::io
