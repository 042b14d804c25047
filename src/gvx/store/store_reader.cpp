#include "gvx/store/store_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "gvx/store/brick_border.h"
#include "gvx/store/codec.h"
#include "gvx/store/header.h"

namespace gvx::store {
namespace {

/// Metadata of four channels have a tenth of a megabyte.
constexpr std::uint64_t kMostMetadataBytes = 16 << 20;

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

/// "y" or "z"; none of anything else.
std::optional<UpAxis> up_of(const nlohmann::json& value) {
  for (const UpAxis axis : {UpAxis::y, UpAxis::z}) {
    if (value == kUpAxisNames[static_cast<std::size_t>(axis)]) return axis;
  }
  return std::nullopt;
}

/// Six numbers, the least corner first, within the volume; none of anything else.
std::optional<Box3d> bounds_of(const nlohmann::json& value, Vec3i dimensions) {
  if (!value.is_array() || value.size() != 6) return std::nullopt;
  for (const auto& number : value) {
    if (!number.is_number()) return std::nullopt;
  }
  const Box3d box{{value[0], value[1], value[2]}, {value[3], value[4], value[5]}};
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.minimum[axis], high = box.maximum[axis];
    if (!(0 <= low && low <= high && high <= static_cast<double>(dimensions[axis]))) return std::nullopt;
  }
  return box;
}

}  // namespace

Result<std::unique_ptr<StoreReader>> StoreReader::open(const std::string& path) {
  GVX_ASSIGN(auto ranges, open_file_ranges(path));
  std::unique_ptr<StoreReader> reader(new StoreReader(path, std::move(ranges)));
  GVX_TRY(reader->read_all_but_bricks());
  return reader;
}

Status StoreReader::read_all_but_bricks() {
  GVX_ASSIGN(const StoreHeader header, read_header(file_));
  version_ = header.version;
  info_ = header.info;
  sections_ = header.sections;
  GVX_ASSIGN(index_, PageIndex::open(file_, header));
  return read_metadata();
}

Status StoreReader::read_metadata() {
  GVX_ASSIGN(const Section section, find_section(file_, sections_, kMetadataSection, kMostMetadataBytes));
  GVX_ASSIGN(const auto bytes, read_section(file_, section));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto metadata = nlohmann::json::parse(text, nullptr, false);
  const auto wrong = [&] { return file_.corrupt("the metadata is not the JSON that gvx writes"); };
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
  if (const auto no_data = metadata.find("noData"); no_data != metadata.end()) {
    if (!no_data->is_boolean()) return wrong();
    info_.no_data = info_.no_data || no_data->get<bool>();
  }
  if (const auto up = metadata.find("up"); up != metadata.end()) {
    const std::optional<UpAxis> axis = up_of(*up);
    if (!axis) return wrong();
    info_.up = *axis;
  }
  if (const auto bounds = metadata.find("bounds"); bounds != metadata.end()) {
    info_.bounds = bounds_of(*bounds, info_.shape.dimensions);
    if (!info_.bounds) return wrong();
  }
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

Result<NodeRecord> StoreReader::node(const NodeKey& key) const {
  GVX_ASSIGN(const NodeRecord record, index_->node(key));
  for (const ValueRange range : record.ranges.channel) {
    if (!is_possible(range, info_.format.type) && !(info_.no_data && range == kNoValues)) {
      return file_.corrupt("the value range of " + node_name(key) + " is impossible");
    }
  }
  return record;
}

Status StoreReader::read_brick(const NodeKey& key, const NodeRecord& record, std::span<std::byte> voxels,
                               std::uint32_t border) const {
  const VoxelFormat format = info_.format;
  if (border < 1 || border > kMostBorder) {
    return Error{path() + ": read_brick: a border of " + std::to_string(border) + " voxels; expected 1 or 2"};
  }
  if (voxels.size() != info_.brick_bytes(border)) {
    return Error{path() + ": read_brick: memory of " + std::to_string(voxels.size()) +
                 " bytes; expected info().brick_bytes(" + std::to_string(border) + "), " +
                 std::to_string(info_.brick_bytes(border))};
  }
  const std::size_t texels = info_.texels(border), stored_texels = info_.texels(info_.border);
  if (record.constant()) {
    std::fill(voxels.begin(), voxels.end(), std::byte{0});
    with_voxel_type(format.type, [&](auto zero) {
      using Voxel = decltype(zero);
      auto* plane = reinterpret_cast<Voxel*>(voxels.data());
      for (std::uint32_t c = 0; c < format.channels(); ++c, plane += texels) {
        const float value = record.ranges.channel[c].minimum;
        std::fill(plane, plane + texels,
                  record.ranges.channel[c] == kNoValues ? std::numeric_limits<Voxel>::quiet_NaN()
                                                        : static_cast<Voxel>(value));
      }
    });
    return {};
  }
  if (border == info_.border) return read_stored(key, record, voxels);
  thread_local std::vector<std::byte> stored;
  stored.resize(info_.brick_bytes(info_.border));
  GVX_TRY(read_stored(key, record, stored));
  with_voxel_type(format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    const auto* from = reinterpret_cast<const Voxel*>(stored.data());
    auto* to = reinterpret_cast<Voxel*>(voxels.data());
    for (std::uint32_t plane = 0; plane < format.planes; ++plane, from += stored_texels, to += texels) {
      change_border(from, info_.shape.m, info_.border, border, format.content == VoxelContent::scalar, to);
    }
    // Deviations have a border of their own, the same in both.
    const auto* rest = reinterpret_cast<const std::byte*>(from);
    std::copy(rest, static_cast<const std::byte*>(stored.data() + stored.size()),
              reinterpret_cast<std::byte*>(to));
  });
  return {};
}

/// Fills `voxels` with the brick as it is stored.
Status StoreReader::read_stored(const NodeKey& key, const NodeRecord& record,
                                std::span<std::byte> voxels) const {
  if (record.bytes > 2 * voxels.size() + 1024) return file_.corrupt(node_name(key) + " is too large");
  if (!file_.has(record.offset, record.bytes)) {
    return file_.corrupt("the brick of " + node_name(key) + " is not within the file");
  }
  thread_local std::vector<std::byte> compressed;
  compressed.resize(record.bytes);
  GVX_TRY(file_.read(record.offset, compressed));
  const TimeSum::Span decoding(file_.decoding());
  if (static_cast<std::uint32_t>(checksum(compressed)) != record.checksum) {
    return file_.corrupt("the checksum of the brick of " + node_name(key) + " does not match");
  }
  const BlockLayout layout{voxel_bytes(info_.format.type), info_.format.planes * info_.texels(info_.border)};
  if (const auto status = decompress(info_.codec, layout, compressed, voxels); !status.ok()) {
    return file_.corrupt("brick of " + node_name(key) + ": " + status.error().message);
  }
  return {};
}

}  // namespace gvx::store
