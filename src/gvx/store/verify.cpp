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
bool sound_deviations(const VolumeInfo& info, const std::vector<std::byte>& brick) {
  const VoxelFormat format = info.format;
  if (!format.has_deviations()) return true;
  const std::byte* deviations =
      brick.data() + format.planes * info.texels(info.border) * voxel_bytes(format.type);
  for (std::uint32_t plane = 0; plane < format.planes; ++plane, deviations += deviation_bytes(info.shape.m)) {
    float unit = 0;
    std::memcpy(&unit, deviations, sizeof(unit));
    if (!(unit >= 0) || std::isinf(unit)) return false;
  }
  return true;
}

/// Of a record's payloads that this program does not know, whatever they hold: are they as they were written?
Status check_other_payloads(const StoreReader& reader, const NodeKey& key) {
  const RecordLayout& layout = reader.index().layout();
  if (layout.other_payloads().empty()) return {};
  GVX_ASSIGN(const PageIndex::Record record, reader.index().record(key));
  for (const RecordLayout::Payload& payload : layout.other_payloads()) {
    BlockRef block{};
    std::memcpy(&block, record.bytes + payload.offset, sizeof(block));
    if (block.bytes == 0) continue;
    const std::string name = "the payload \"" + payload.name + "\" of " + node_name(key);
    if (!reader.file().has(block.offset, block.bytes)) {
      return reader.file().corrupt(name + " is not within the file");
    }
    GVX_ASSIGN(const std::uint64_t sum, reader.file().checksum_of(block.offset, block.bytes));
    if (static_cast<std::uint32_t>(sum) != block.checksum) {
      return reader.file().corrupt("the checksum of " + name + " does not match");
    }
  }
  return {};
}

/// Is the node's record within its parent's, which is `above`?
Status check_range(const StoreReader& reader, const NodeKey& key, const NodeRecord& record,
                   const ChannelRanges& above) {
  if (!above.contains(record.ranges)) {
    return reader.file().corrupt("the range of " + node_name(key) + " is not within its parent's");
  }
  const bool has_range = !record.ranges.constant() && !record.no_data(reader.info().format.channels());
  if (record.constant() && has_range) {
    return reader.file().corrupt(node_name(key) + " has a range but no brick");
  }
  return {};
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
  GVX_TRY(check_range(reader, key, record, above));
  GVX_TRY(check_other_payloads(reader, key));
  ++report.nodes;
  if (record.constant()) {
    ++report.constant_nodes;
    return {};
  }
  ++report.bricks;
  GVX_TRY(reader.read_brick(key, record, voxels, reader.info().border));
  const VoxelFormat format = reader.info().format;
  const std::size_t texels = reader.info().texels(reader.info().border);
  const bool colored = format.content == VoxelContent::color || format.content == VoxelContent::color_normal;
  const bool no_data = reader.info().no_data;
  const bool sound = with_voxel_type(format.type, [&](auto zero) {
    using Voxel = decltype(zero);
    const auto* plane = reinterpret_cast<const Voxel*>(voxels.data()) + (colored ? 3 * texels : 0);
    bool inside = true;
    for (std::uint32_t c = 0; c < format.channels(); ++c, plane += texels) {
      const ValueRange range = record.ranges.channel[c];
      inside = inside && std::all_of(plane, plane + texels, [&](Voxel v) {
                 return range.contains(static_cast<float>(v)) || (no_data && v != v);
               });
    }
    return inside;
  });
  if (!sound) return reader.file().corrupt("a voxel of " + node_name(key) + " is outside its range");
  if (!sound_deviations(reader.info(), voxels)) {
    return reader.file().corrupt("the deviations of " + node_name(key) + " have no finite unit");
  }
  return {};
}

NodeKey key_at(std::uint32_t level, Vec3i node) {
  return {level, static_cast<std::uint64_t>(node.x), static_cast<std::uint64_t>(node.y),
          static_cast<std::uint64_t>(node.z)};
}

/// Calls function(key) for all nodes of a box, up to the first error.
template <typename Function>
Status for_each_node(const NodeBox& box, const Function& function) {
  for (std::int64_t z = box.first.z; z < box.last.z; ++z) {
    for (std::int64_t y = box.first.y; y < box.last.y; ++y) {
      for (std::int64_t x = box.first.x; x < box.last.x; ++x) {
        GVX_TRY(function(key_at(box.level, {x, y, z})));
      }
    }
  }
  return {};
}

/// The same as check_node() for nodes that have one record.
Status check_nodes_of_one_record(const StoreReader& reader, const NodeBox& part, VerifyReport& report) {
  const NodeKey key = key_at(part.level, part.first);
  GVX_ASSIGN(const NodeRecord record, reader.node(key));
  GVX_TRY(check_other_payloads(reader, key));
  report.nodes += part.nodes();
  report.constant_nodes += part.nodes();
  if (part.level == 0) return check_range(reader, key, record, reader.info().ranges);
  const std::int64_t n = reader.info().shape.n;
  const NodeBox parents{part.level - 1, part.first / Vec3i(n), (part.last + Vec3i(n - 1)) / Vec3i(n)};
  const auto check_below = [&](const NodeKey& above) -> Status {
    GVX_ASSIGN(const NodeRecord parent_record, reader.node(above));
    return check_range(reader, key, record, parent_record.ranges);
  };
  return reader.index().for_each_page(parents, [&](const PageIndex::Part& above) {
    return above.one_record ? check_below(key_at(above.nodes.level, above.nodes.first))
                            : for_each_node(above.nodes, check_below);
  });
}

Status check_sections(const StoreReader& reader) {
  for (const Section& section : reader.sections()) {
    GVX_ASSIGN(const std::uint64_t sum, reader.file().checksum_of(section.offset, section.bytes));
    if (sum != section.checksum) {
      return reader.file().corrupt("the checksum of section \"" + section.name + "\" does not match");
    }
  }
  return {};
}

/// Checks parts of the index, some at a time, on all threads.
class Checker {
 public:
  Checker(const exec::Device& cpu, const StoreReader& reader,
          const std::function<void(std::uint64_t, std::uint64_t)>& progress)
      : cpu_(cpu), reader_(reader), progress_(progress), all_(reader.info().shape.nodes()) {}

  Status level(std::uint32_t level) {
    const std::uint64_t before = used_bytes_;
    GVX_TRY(reader_.index().for_each_page({level, {}, reader_.info().shape.level_nodes(level)},
                                          [&](const PageIndex::Part& part) {
                                            used_bytes_ = before + part.page_bytes;
                                            return add(part);
                                          }));
    return check_parts();
  }

  const VerifyReport& report() const { return report_; }

 private:
  static constexpr std::size_t kPartsAtOnce = 1024;

  /// Of a page whose nodes have records of their own each layer is a part: small stores have few pages.
  Status add(const PageIndex::Part& part) {
    // A few pages, each named by many others, would be a tree of any size.
    if (used_bytes_ > reader_.file().size_bytes()) {
      return reader_.file().corrupt("its index pages have more bytes than the file: some are used twice");
    }
    if (part.one_record) {
      parts_.push_back(part);
    } else {
      for (std::int64_t z = part.nodes.first.z; z < part.nodes.last.z; ++z) {
        PageIndex::Part& layer = parts_.emplace_back(part);
        layer.nodes.first.z = z;
        layer.nodes.last.z = z + 1;
      }
    }
    return parts_.size() < kPartsAtOnce ? Status() : check_parts();
  }

  Status check_parts() {
    Status status;
    exec::parallel_for(cpu_, parts_.size(), [&](std::size_t i) {
      VerifyReport of_part;
      const Status checked = check(parts_[i], of_part);
      const std::lock_guard lock(mutex_);
      if (!checked.ok() && status.ok()) status = checked;
      report_.nodes += of_part.nodes;
      report_.bricks += of_part.bricks;
      report_.constant_nodes += of_part.constant_nodes;
      if (progress_) progress_(report_.nodes, all_);
    });
    parts_.clear();
    return status;
  }

  Status check(const PageIndex::Part& part, VerifyReport& report) {
    if (part.one_record) return check_nodes_of_one_record(reader_, part.nodes, report);
    std::vector<std::byte> voxels(reader_.info().brick_bytes(reader_.info().border));
    return for_each_node(part.nodes,
                         [&](const NodeKey& key) { return check_node(reader_, key, voxels, report); });
  }

  const exec::Device& cpu_;
  const StoreReader& reader_;
  const std::function<void(std::uint64_t, std::uint64_t)>& progress_;
  const std::uint64_t all_;
  std::vector<PageIndex::Part> parts_;
  std::uint64_t used_bytes_ = 0;  ///< by pages
  std::mutex mutex_;
  VerifyReport report_;
};

}  // namespace

Result<VerifyReport> verify(const exec::Device& cpu, const std::string& path,
                            const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  if (cpu.kind() != exec::DeviceKind::cpu)
    return Error{"verify: runs on the CPU only; expected Device::cpu()"};
  GVX_ASSIGN(const auto reader, StoreReader::open(path));
  GVX_TRY(check_sections(*reader));
  Checker checker(cpu, *reader, progress);
  for (std::uint32_t level = 0; level < reader->info().shape.levels; ++level) GVX_TRY(checker.level(level));
  VerifyReport report = checker.report();
  report.bytes_read = reader->bytes_read();
  return report;
}

}  // namespace gvx::store
