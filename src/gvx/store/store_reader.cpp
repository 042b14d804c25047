#include "gvx/store/store_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "gvx/store/codec.h"

namespace gvx::store {
namespace {

// 24 KiB a page: 96 MiB, the records of two million nodes. Beyond it all are dropped and read again as
// needed.
constexpr std::size_t kPagesKept = 4096;

VoxelFormat format_of(const FileHeader& header) {
  return {static_cast<VoxelType>(header.voxel_type), static_cast<VoxelContent>(header.content),
          header.planes};
}

// 2^31-1 along each axis are fewer; sums of a thousand bins stay below 2^64 all the same.
constexpr std::uint64_t kMostVoxels = 1ull << 53;

/// Can voxels of the type have these values?
bool is_possible(ValueRange range, VoxelType type) {
  const float greatest = type == VoxelType::u8    ? 255.0f
                         : type == VoxelType::u16 ? 65535.0f
                                                  : std::numeric_limits<float>::max();
  const float least = type == VoxelType::f32 ? -greatest : 0.0f;
  return least <= range.minimum && range.minimum <= range.maximum && range.maximum <= greatest;
}

/// The message for a header field that is out of its bounds, or empty.
std::string wrong_field(const FileHeader& header, std::uint64_t file_bytes) {
  if (header.header_bytes != sizeof(FileHeader)) return "header size";
  if (header.n != 2 && header.n != 3) return "tree arity N";
  if (header.m != 8 && header.m != 16 && header.m != 32) return "brick size M";
  if (header.voxel_type < 1 || header.voxel_type > 3) return "voxel type";
  if (header.codec > 2) return "codec";
  if (header.content > 3 || !format_of(header).valid()) return "voxel content";
  for (const std::uint64_t d : header.dimensions) {
    if (d < 1 || d > 0x7fffffff) return "dimensions";
  }
  const TreeShape shape = TreeShape::covering(
      {static_cast<std::int64_t>(header.dimensions[0]), static_cast<std::int64_t>(header.dimensions[1]),
       static_cast<std::int64_t>(header.dimensions[2])},
      header.n, header.m);
  if (header.levels != shape.levels) return "number of levels";
  if (header.page_edge != kPageEdge) return "index page size";
  if (header.directory_bytes / sizeof(PageEntry) != shape.pages_before(shape.levels) ||
      header.directory_bytes % sizeof(PageEntry) != 0) {
    return "directory size";
  }
  for (const double v : header.voxel_to_world) {
    if (!std::isfinite(v)) return "voxel-to-world matrix";
  }
  if (!std::isfinite(header.scale) || !std::isfinite(header.offset) || header.scale == 0)
    return "value scale";
  if (!(header.range.minimum <= header.range.maximum)) return "value range";
  const auto within = [&](std::uint64_t offset, std::uint64_t bytes) {
    return offset <= file_bytes && bytes <= file_bytes - offset;
  };
  if (!within(header.directory_offset, header.directory_bytes)) return "directory position";
  if (!within(header.metadata_offset, header.metadata_bytes)) return "metadata position";
  return {};
}

}  // namespace

Result<std::unique_ptr<StoreReader>> StoreReader::open(const std::string& path) {
  GVX_ASSIGN(auto ranges, open_file_ranges(path));
  std::unique_ptr<StoreReader> reader(new StoreReader(path, std::move(ranges)));
  GVX_TRY(reader->read_header());
  return reader;
}

Status StoreReader::read_range(std::uint64_t offset, std::span<std::byte> out) const {
  const TimeSum::Span reading(reading_);
  GVX_TRY(ranges_->read(offset, out));
  bytes_read_.fetch_add(out.size(), std::memory_order_relaxed);
  return {};
}

Status StoreReader::read_header() {
  FileHeader header{};
  if (ranges_->size_bytes() < sizeof(header))
    return Error{path_ + ": not a .gvx store: too short for a header"};
  GVX_TRY(read_range(0, std::as_writable_bytes(std::span(&header, 1))));
  if (header.magic != kMagic) return Error{path_ + ": not a .gvx store: no GVXSTORE at its start"};
  if (header.version != kVersion) {
    return Error{path_ + ": .gvx version " + std::to_string(header.version) + "; this gvx reads version " +
                 std::to_string(kVersion) + ": build the store again"};
  }
  const auto bytes = std::as_bytes(std::span(&header, 1));
  if (checksum(bytes.first(offsetof(FileHeader, header_checksum))) != header.header_checksum) {
    return Error{path_ + ": corrupt: the header's checksum does not match"};
  }
  if (header.file_bytes != ranges_->size_bytes()) {
    return Error{path_ + ": corrupt: " + std::to_string(ranges_->size_bytes()) + " bytes long, " +
                 std::to_string(header.file_bytes) + " expected"};
  }
  if (const std::string field = wrong_field(header, header.file_bytes); !field.empty()) {
    return Error{path_ + ": corrupt: the header's " + field + " is not one that gvx writes"};
  }

  info_.shape = TreeShape{
      header.n,
      header.m,
      {static_cast<std::int64_t>(header.dimensions[0]), static_cast<std::int64_t>(header.dimensions[1]),
       static_cast<std::int64_t>(header.dimensions[2])},
      header.levels};
  info_.format = format_of(header);
  info_.codec = static_cast<Codec>(header.codec);
  const double* matrix = header.voxel_to_world;
  for (int c = 0; c < 3; ++c)
    info_.voxel_to_world.column[c] = {matrix[3 * c], matrix[3 * c + 1], matrix[3 * c + 2]};
  info_.voxel_to_world.origin = {matrix[9], matrix[10], matrix[11]};
  if (const Status placed = check_placement(info_.voxel_to_world); !placed.ok()) {
    return Error{path_ + ": corrupt: " + placed.error().message};
  }
  info_.scale = header.scale;
  info_.offset = header.offset;

  directory_.resize(header.directory_bytes / sizeof(PageEntry));
  const auto directory = std::as_writable_bytes(std::span(directory_));
  GVX_TRY(read_range(header.directory_offset, directory));
  if (checksum(directory) != header.directory_checksum) {
    return Error{path_ + ": corrupt: the directory's checksum does not match"};
  }
  return read_metadata(header);
}

Status StoreReader::read_metadata(const FileHeader& header) {
  std::string text(header.metadata_bytes, '\0');
  const auto bytes = std::as_writable_bytes(std::span(text));
  GVX_TRY(read_range(header.metadata_offset, bytes));
  if (checksum(bytes) != header.metadata_checksum) {
    return Error{path_ + ": corrupt: the metadata's checksum does not match"};
  }
  const auto metadata = nlohmann::json::parse(text, nullptr, false);
  const auto wrong = [&] { return Error{path_ + ": corrupt: the metadata is not the JSON that gvx writes"}; };
  if (!metadata.is_object()) return wrong();
  const auto source = metadata.find("source");
  const auto anatomical = metadata.find("anatomical");
  const auto channels = metadata.find("channels");
  if (source == metadata.end() || !source->is_string() || anatomical == metadata.end() ||
      !anatomical->is_boolean() || channels == metadata.end() || !channels->is_array() ||
      channels->size() != info_.format.channels()) {
    return wrong();
  }
  info_.source = source->get<std::string>();
  info_.anatomical = anatomical->get<bool>();
  for (std::size_t c = 0; c < channels->size(); ++c) {
    const auto& channel = (*channels)[c];
    if (!channel.is_object() || !channel.contains("range") || !channel.contains("histogram")) return wrong();
    const auto& range = channel["range"];
    if (!range.is_array() || range.size() != 2 || !range[0].is_number() || !range[1].is_number())
      return wrong();
    info_.ranges.channel[c] = {range[0].get<float>(), range[1].get<float>()};
    if (!is_possible(info_.ranges.channel[c], info_.format.type)) return wrong();
    if (!channel["histogram"].is_array() || channel["histogram"].size() != kHistogramBins) return wrong();
    auto& bins = info_.histograms.emplace_back();
    for (const auto& bin : channel["histogram"]) {
      if (!bin.is_number_unsigned() || bin.get<std::uint64_t>() > kMostVoxels) return wrong();
      bins.push_back(bin.get<std::uint64_t>());
    }
  }
  return {};
}

Result<std::shared_ptr<const IndexPage>> StoreReader::page(std::uint64_t index) const {
  {
    const std::lock_guard lock(pages_mutex_);
    if (const auto found = pages_.find(index); found != pages_.end()) return found->second;
  }
  GVX_CHECK(index < directory_.size());
  const PageEntry& entry = directory_[index];
  if (entry.bytes > 2 * kPageNodes * sizeof(NodeRecord)) {
    return Error{path_ + ": corrupt: index page " + std::to_string(index) + " is too large"};
  }
  std::vector<std::byte> compressed(entry.bytes);
  GVX_TRY(read_range(entry.offset, compressed));
  const TimeSum::Span decoding(decoding_);
  if (static_cast<std::uint32_t>(checksum(compressed)) != entry.checksum) {
    return Error{path_ + ": corrupt: the checksum of index page " + std::to_string(index) +
                 " does not match"};
  }
  auto records = std::make_shared<IndexPage>(kPageNodes);
  if (const auto status = decompress(Codec::zstd, {sizeof(NodeRecord), kPageNodes}, compressed,
                                     std::as_writable_bytes(std::span(*records)));
      !status.ok()) {
    return Error{path_ + ": corrupt: index page " + std::to_string(index) + ": " + status.error().message};
  }
  const std::lock_guard lock(pages_mutex_);
  if (pages_.size() >= kPagesKept) pages_.clear();
  pages_[index] = records;
  return std::shared_ptr<const IndexPage>(records);
}

Result<NodeRecord> StoreReader::node(const NodeKey& key) const {
  GVX_CHECK(info_.shape.contains(key));
  const Vec3i pages = info_.shape.level_pages(key.level);
  const std::uint64_t px = key.x / kPageEdge, py = key.y / kPageEdge, pz = key.z / kPageEdge;
  const auto across = static_cast<std::uint64_t>(pages.x), down = static_cast<std::uint64_t>(pages.y);
  const std::uint64_t index = info_.shape.pages_before(key.level) + (pz * down + py) * across + px;
  GVX_ASSIGN(const auto records, page(index));
  const std::uint64_t x = key.x % kPageEdge, y = key.y % kPageEdge, z = key.z % kPageEdge;
  const NodeRecord record = (*records)[(z * kPageEdge + y) * kPageEdge + x];
  for (const ValueRange range : record.ranges.channel) {
    if (!is_possible(range, info_.format.type)) {
      return Error{path_ + ": corrupt: the value range of " + node_name(key) + " is impossible"};
    }
  }
  return record;
}

Status StoreReader::read_brick(const NodeKey& key, const NodeRecord& record,
                               std::span<std::byte> voxels) const {
  const VoxelFormat format = info_.format;
  const std::size_t element = voxel_bytes(format.type), texels = plane_texels(info_.shape.m);
  GVX_CHECK(voxels.size() == info_.brick_bytes());
  if (record.constant()) {
    std::fill(voxels.begin(), voxels.end(), std::byte{0});
    with_voxel_type(format.type, [&](auto zero) {
      using Voxel = decltype(zero);
      auto* plane = reinterpret_cast<Voxel*>(voxels.data());
      for (std::uint32_t c = 0; c < format.channels(); ++c, plane += texels) {
        std::fill(plane, plane + texels, static_cast<Voxel>(record.ranges.channel[c].minimum));
      }
    });
    return {};
  }
  if (record.bytes > 2 * voxels.size() + 1024)
    return Error{path_ + ": corrupt: " + node_name(key) + " is too large"};
  thread_local std::vector<std::byte> compressed;
  compressed.resize(record.bytes);
  GVX_TRY(read_range(record.offset, compressed));
  const TimeSum::Span decoding(decoding_);
  if (static_cast<std::uint32_t>(checksum(compressed)) != record.checksum) {
    return Error{path_ + ": corrupt: the checksum of the brick of " + node_name(key) + " does not match"};
  }
  if (const auto status = decompress(info_.codec, {element, format.planes * texels}, compressed, voxels);
      !status.ok()) {
    return Error{path_ + ": corrupt: brick of " + node_name(key) + ": " + status.error().message};
  }
  return {};
}

}  // namespace gvx::store
