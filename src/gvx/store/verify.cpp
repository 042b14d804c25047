#include "gvx/store/verify.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <vector>

#include "gvx/exec/parallel.h"
#include "gvx/store/store_reader.h"

namespace gvx::store {
namespace {

/// Are the units of a brick's deviations numbers?
bool sound_deviations(const VoxelFormat& format, std::size_t m, const std::vector<std::byte>& brick) {
  if (!format.has_deviations()) return true;
  const std::byte* deviations = brick.data() + format.planes * plane_texels(m) * voxel_bytes(format.type);
  for (std::uint32_t plane = 0; plane < format.planes; ++plane, deviations += deviation_bytes(m)) {
    float unit = 0;
    std::memcpy(&unit, deviations, sizeof(unit));
    if (!(unit >= 0) || std::isinf(unit)) return false;
  }
  return true;
}

/// Reads the node's brick and says whether each voxel lies in the record's range.
Status check_node(const StoreReader& reader, const NodeKey& key, std::vector<std::byte>& voxels,
                  VerifyReport& report) {
  GVX_ASSIGN(const NodeRecord record, reader.node(key));
  ChannelRanges above = reader.info().ranges;
  if (key.level > 0) {
    GVX_ASSIGN(const NodeRecord parent_record,
               reader.node(parent(key, static_cast<int>(reader.info().shape.n))));
    above = parent_record.ranges;
  }
  if (!above.contains(record.ranges)) {
    return Error{reader.path() + ": corrupt: the range of " + node_name(key) + " is not within its parent's"};
  }
  ++report.nodes;
  if (record.constant()) {
    ++report.constant_nodes;
    if (!record.ranges.constant()) {
      return Error{reader.path() + ": corrupt: " + node_name(key) + " has a range but no brick"};
    }
    return {};
  }
  ++report.bricks;
  GVX_TRY(reader.read_brick(key, record, voxels));
  const VoxelFormat format = reader.info().format;
  const std::size_t texels = plane_texels(reader.info().shape.m);
  const bool colored = format.content == VoxelContent::color || format.content == VoxelContent::color_normal;
  const bool sound = with_voxel_type(format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    const auto* plane = reinterpret_cast<const Voxel*>(voxels.data()) + (colored ? 3 * texels : 0);
    bool inside = true;
    for (std::uint32_t c = 0; c < format.channels(); ++c, plane += texels) {
      const ValueRange range = record.ranges.channel[c];
      inside = inside && std::all_of(plane, plane + texels,
                                     [&](Voxel v) { return range.contains(static_cast<float>(v)); });
    }
    return inside;
  });
  if (!sound) {
    return Error{reader.path() + ": corrupt: a voxel of " + node_name(key) + " is outside its range"};
  }
  if (!sound_deviations(format, reader.info().shape.m, voxels)) {
    return Error{reader.path() + ": corrupt: the deviations of " + node_name(key) + " have no finite unit"};
  }
  return {};
}

}  // namespace

Result<VerifyReport> verify(const exec::Device& cpu, const std::string& path,
                            const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  GVX_ASSIGN(const auto reader, StoreReader::open(path));
  const TreeShape& shape = reader->info().shape;
  const std::uint64_t all = shape.nodes();
  VerifyReport report;
  Status status;
  std::mutex mutex;
  for (std::uint32_t l = 0; l < shape.levels && status.ok(); ++l) {
    const Vec3i nodes = shape.level_nodes(l);
    exec::parallel_for(cpu, static_cast<std::size_t>(nodes.y * nodes.z), [&](std::size_t index) {
      const auto row = static_cast<std::int64_t>(index);
      std::vector<std::byte> voxels(reader->info().brick_bytes());
      VerifyReport of_row;
      Status row_status;
      for (std::int64_t x = 0; x < nodes.x && row_status.ok(); ++x) {
        row_status = check_node(*reader,
                                {l, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(row % nodes.y),
                                 static_cast<std::uint32_t>(row / nodes.y)},
                                voxels, of_row);
      }
      const std::lock_guard lock(mutex);
      if (!row_status.ok() && status.ok()) status = row_status;
      report.nodes += of_row.nodes;
      report.bricks += of_row.bricks;
      report.constant_nodes += of_row.constant_nodes;
      if (progress) progress(report.nodes, all);
    });
  }
  GVX_TRY(status);
  report.bytes_read = reader->bytes_read();
  return report;
}

}  // namespace gvx::store
