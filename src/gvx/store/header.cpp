#include "gvx/store/header.h"

#include <cmath>
#include <cstring>

namespace gvx::store {
namespace {

/// The header of version 2, which agrees with today's in its first 176 bytes.
struct HeaderVersion2 {
  std::array<std::byte, 176> as_today;
  ValueRange range;
  std::uint64_t directory_offset, directory_bytes, directory_checksum;
  std::uint64_t metadata_offset, metadata_bytes, metadata_checksum;
  std::uint64_t file_bytes;
  std::uint32_t content, planes;
  std::uint64_t header_checksum;
};
static_assert(sizeof(HeaderVersion2) == sizeof(FileHeader) && offsetof(FileHeader, content) == 176);
static_assert(offsetof(HeaderVersion2, header_checksum) == offsetof(FileHeader, header_checksum));

/// A header of version 2 in today's words.
FileHeader as_today(const HeaderVersion2& old) {
  FileHeader header{};
  std::memcpy(&header, old.as_today.data(), old.as_today.size());
  header.content = old.content;
  header.planes = old.planes;
  header.border = 1;
  header.file_bytes = old.file_bytes;
  return header;
}

VoxelFormat format_of(const FileHeader& header) {
  return {static_cast<VoxelType>(header.voxel_type), static_cast<VoxelContent>(header.content),
          header.planes};
}

Vec3i dimensions_of(const FileHeader& header) {
  return {static_cast<std::int64_t>(header.dimensions[0]), static_cast<std::int64_t>(header.dimensions[1]),
          static_cast<std::int64_t>(header.dimensions[2])};
}

/// The name of a field that is out of its bounds, or empty.
std::string wrong_field(const FileHeader& header) {
  if (header.header_bytes != sizeof(FileHeader)) return "header size";
  if (header.n != 2 && header.n != 3) return "tree arity N";
  if (header.m != 8 && header.m != 16 && header.m != 32) return "brick size M";
  if (header.voxel_type < 1 || header.voxel_type > 3) return "voxel type";
  if (header.codec > 2) return "codec";
  if (header.content > 3 || !format_of(header).valid()) return "voxel content";
  if (header.border < 1 || header.border > kMostBorder) return "border";
  for (const std::uint64_t d : header.dimensions) {
    if (d < 1 || d > 0x7fffffff) return "dimensions";
  }
  const TreeShape shape = TreeShape::covering(dimensions_of(header), header.n, header.m);
  if (header.levels != shape.levels) return "number of levels";
  if (header.page_edge != kPageEdge) return "index page size";
  for (const double v : header.voxel_to_world) {
    if (!std::isfinite(v)) return "voxel-to-world matrix";
  }
  if (!std::isfinite(header.scale) || !std::isfinite(header.offset) || header.scale == 0)
    return "value scale";
  return {};
}

Result<VolumeInfo> info_of(const StoreFile& file, const FileHeader& header) {
  VolumeInfo info;
  info.shape = TreeShape{header.n, header.m, dimensions_of(header), header.levels};
  info.format = format_of(header);
  info.codec = static_cast<Codec>(header.codec);
  info.border = header.border;
  info.no_data = (header.flags & kNoData) != 0;
  const double* matrix = header.voxel_to_world;
  for (int c = 0; c < 3; ++c)
    info.voxel_to_world.column[c] = {matrix[3 * c], matrix[3 * c + 1], matrix[3 * c + 2]};
  info.voxel_to_world.origin = {matrix[9], matrix[10], matrix[11]};
  if (const Status placed = check_placement(info.voxel_to_world); !placed.ok()) {
    return file.corrupt(placed.error().message);
  }
  info.scale = header.scale;
  info.offset = header.offset;
  return info;
}

Result<std::vector<Section>> sections_of(const StoreFile& file, const HeaderVersion2& old) {
  const SectionEntry table[] = {{stored_name(kDirectorySection), 1, 1, 0, old.directory_offset,
                                 old.directory_bytes, old.directory_checksum},
                                {stored_name(kMetadataSection), 1, 1, 0, old.metadata_offset,
                                 old.metadata_bytes, old.metadata_checksum}};
  return parse_sections(file, table, sizeof(FileHeader));
}

}  // namespace

Result<StoreHeader> read_header(const StoreFile& file) {
  std::array<std::byte, sizeof(FileHeader)> bytes{};
  if (file.size_bytes() < bytes.size())
    return Error{file.path() + ": not a .gvx store: too short for a header"};
  GVX_TRY(file.read(0, bytes));
  FileHeader header{};
  std::memcpy(&header, bytes.data(), bytes.size());
  if (header.magic != kMagic) return Error{file.path() + ": not a .gvx store: no GVXSTORE at its start"};
  if (header.version > kVersion) {
    return Error{file.path() + ": made by a newer gvx: version " + std::to_string(header.version) +
                 "; this program reads up to " + std::to_string(kVersion)};
  }
  if (header.version < kOldestVersion) {
    return Error{file.path() + ": .gvx version " + std::to_string(header.version) +
                 "; this program reads versions " + std::to_string(kOldestVersion) + " to " +
                 std::to_string(kVersion) + ": build the store again"};
  }
  if (checksum(std::span(bytes).first(offsetof(FileHeader, header_checksum))) != header.header_checksum) {
    return file.corrupt("the header's checksum does not match");
  }
  HeaderVersion2 old{};
  if (header.version == 2) {
    std::memcpy(&old, bytes.data(), bytes.size());
    header = as_today(old);
  }
  if (header.file_bytes != file.size_bytes()) {
    return file.corrupt(std::to_string(file.size_bytes()) + " bytes long, " +
                        std::to_string(header.file_bytes) + " expected");
  }
  if ((header.flags & ~kNoData) != 0) {
    return Error{file.path() +
                 ": made by a newer gvx: the header has flags that this program does not know (" +
                 std::to_string(header.flags) + ")"};
  }
  if (const std::string field = wrong_field(header); !field.empty()) {
    return file.corrupt("the header's " + field + " is not one that gvx writes");
  }

  StoreHeader result;
  result.version = header.version;
  result.record_bytes = header.record_bytes;
  GVX_ASSIGN(result.info, info_of(file, header));
  const SectionTable table{header.sections, header.table_offset, header.table_checksum};
  GVX_ASSIGN(result.sections,
             header.version == 2 ? sections_of(file, old) : read_sections(file, table, sizeof(FileHeader)));
  constexpr const char* kKnown[] = {kDirectorySection, kRecordsSection, kMetadataSection};
  GVX_TRY(check_required(file, result.sections, kKnown));
  return result;
}

FileHeader header_of(const VolumeInfo& info, std::uint32_t record_bytes) {
  FileHeader header{};
  header.magic = kMagic;
  header.version = kVersion;
  header.header_bytes = sizeof(FileHeader);
  header.n = info.shape.n;
  header.m = info.shape.m;
  header.voxel_type = static_cast<std::uint32_t>(info.format.type);
  header.codec = static_cast<std::uint32_t>(info.codec);
  for (int axis = 0; axis < 3; ++axis) {
    header.dimensions[axis] = static_cast<std::uint64_t>(info.shape.dimensions[axis]);
  }
  header.levels = info.shape.levels;
  header.page_edge = kPageEdge;
  for (int i = 0; i < 12; ++i) {
    header.voxel_to_world[i] =
        i < 9 ? info.voxel_to_world.column[i / 3][i % 3] : info.voxel_to_world.origin[i % 3];
  }
  header.scale = info.scale;
  header.offset = info.offset;
  header.content = static_cast<std::uint32_t>(info.format.content);
  header.planes = info.format.planes;
  header.border = info.border;
  header.flags = info.no_data ? kNoData : 0;
  header.record_bytes = record_bytes;
  return header;
}

}  // namespace gvx::store
