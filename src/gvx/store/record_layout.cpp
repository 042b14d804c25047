#include "gvx/store/record_layout.h"

#include <cstring>
#include <set>

namespace gvx::store {
namespace {

constexpr std::uint32_t kRequired = 1;
constexpr const char* kVoxels = "voxels";
constexpr const char* kRanges = "ranges";
constexpr std::uint32_t kRangeBytes = sizeof(ValueRange);

RecordField field(const std::string& name, FieldKind kind, std::uint32_t offset, std::uint32_t bytes,
                  bool required) {
  return {stored_name(name), static_cast<std::uint32_t>(kind), offset, bytes, required ? kRequired : 0};
}

}  // namespace

RecordLayout::RecordLayout(const VoxelFormat& format, std::span<const Extra> extras)
    : voxels_(0), ranges_(sizeof(BlockRef)), channels_(format.channels()) {
  bytes_ = ranges_ + channels_ * kRangeBytes;
  fields_ = {field(kVoxels, FieldKind::payload, voxels_, sizeof(BlockRef), true),
             field(kRanges, FieldKind::values, ranges_, channels_ * kRangeBytes, true)};
  for (const Extra& extra : extras) {
    fields_.push_back(field(extra.name, extra.kind, bytes_, extra.bytes, extra.required));
    if (extra.kind == FieldKind::payload) others_.push_back({extra.name, bytes_});
    bytes_ += extra.bytes;
  }
  GVX_CHECK(bytes_ <= kMostRecordBytes && fields_.size() <= kMostFields);
}

RecordLayout RecordLayout::version2() {
  RecordLayout layout;
  layout.ranges_ = sizeof(BlockRef);
  layout.channels_ = kMaxChannels;
  layout.bytes_ = sizeof(BlockRef) + kMaxChannels * kRangeBytes;
  return layout;
}

Result<RecordLayout> RecordLayout::parse(const StoreFile& file, std::span<const RecordField> fields,
                                         std::uint32_t record_bytes, const VoxelFormat& format) {
  RecordLayout layout;
  layout.bytes_ = record_bytes;
  layout.channels_ = format.channels();
  layout.fields_.assign(fields.begin(), fields.end());
  std::uint32_t end = 0;
  std::set<std::string> names;
  for (const RecordField& f : fields) {
    const std::string name = name_of(f.name);
    const auto kind = static_cast<FieldKind>(f.kind);
    if (name.empty()) return file.corrupt("a field of the node records has no printable name");
    if (!names.insert(name).second) return file.corrupt("node records have two fields \"" + name + "\"");
    if (f.offset < end || f.offset > record_bytes || f.bytes > record_bytes - f.offset) {
      return file.corrupt("field \"" + name + "\" of the node records is not within its record");
    }
    end = f.offset + f.bytes;
    const bool voxels = name == kVoxels, ranges = name == kRanges;
    const bool payload = kind == FieldKind::payload;
    if ((payload && f.bytes != sizeof(BlockRef)) || (voxels && !payload) ||
        (ranges && (kind != FieldKind::values || f.bytes != layout.channels_ * kRangeBytes))) {
      return file.corrupt("field \"" + name + "\" of the node records is not one that gvx writes");
    }
    if (voxels) {
      layout.voxels_ = f.offset;
    } else if (ranges) {
      layout.ranges_ = f.offset;
    } else if ((f.flags & kRequired) != 0) {
      return Error{file.path() + ": made by a newer gvx: this program does not know field \"" + name +
                   "\" of the node records, which is required to read the store"};
    } else if (payload) {
      layout.others_.push_back({name, f.offset});
    }
  }
  for (const char* needed : {kVoxels, kRanges}) {
    if (!names.contains(needed)) {
      return file.corrupt(std::string("node records have no field \"") + needed + "\"");
    }
  }
  return layout;
}

NodeRecord RecordLayout::decode(const std::byte* record) const {
  BlockRef brick{};
  std::memcpy(&brick, record + voxels_, sizeof(brick));
  NodeRecord node{brick.offset, brick.bytes, brick.checksum, {}};
  std::memcpy(node.ranges.channel, record + ranges_, channels_ * kRangeBytes);
  return node;
}

void RecordLayout::encode(const NodeRecord& node, std::byte* record) const {
  const BlockRef brick{node.offset, node.bytes, node.checksum};
  std::memcpy(record + voxels_, &brick, sizeof(brick));
  std::memcpy(record + ranges_, node.ranges.channel, channels_ * kRangeBytes);
}

}  // namespace gvx::store
