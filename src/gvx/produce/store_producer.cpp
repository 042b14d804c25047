#include "gvx/produce/store_producer.h"

#include <cmath>
#include <limits>

#include "gvx/store/notes.h"

namespace gvx::produce {

StoreProducer::StoreProducer(std::unique_ptr<store::StoreReader> reader) : reader_(std::move(reader)) {
  if (reader_ == nullptr) return;
  const store::VolumeInfo& info = reader_->info();
  const double cube = info.shape.cube_voxels();
  static_cast<VolumeDescription&>(description_) = info;
  description_.n = info.shape.n;
  description_.m = info.shape.m;
  description_.max_level = info.shape.levels - 1;
  description_.exact_ranges = true;
  description_.tree_to_world = info.voxel_to_world * scaling(Vec3d(cube));
  description_.extent = {{0, 0, 0}, Vec3d(info.shape.dimensions) / cube};
  if (info.bounds) description_.bounds = Box3d{info.bounds->minimum / cube, info.bounds->maximum / cube};
  // Broken notes are found by verify; they are no reason not to show the volume.
  if (const auto notes = store::read_notes(*reader_); notes.ok()) {
    for (const store::ChannelNotes& channel : notes.value().channels)
      description_.channel_colors.push_back(channel.color);
  }
  description_.bricks = info.shape.nodes();
}

Status StoreProducer::describe(std::span<const NodeKey> keys, std::span<tree::NodeInfo> infos) const {
  if (reader_ == nullptr) return Error{"store: the reader is null; expected an open store"};
  const store::VolumeInfo& info = reader_->info();
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (!info.shape.contains(keys[i])) {
      // Beyond the volume, where no ray samples: any constant within the parent's range will do.
      const NodeKey above = parent(keys[i], static_cast<int>(description_.n));
      const bool known = info.shape.contains(above);
      GVX_ASSIGN(const store::NodeRecord record, reader_->node(known ? above : NodeKey{}));
      infos[i] = {record.ranges.at_minimum(), true};
      continue;
    }
    GVX_ASSIGN(const store::NodeRecord record, reader_->node(keys[i]));
    infos[i] = {record.ranges, keys[i].level == description_.max_level};
    if (!record.constant() && record.ranges.constant()) {
      // One value and no data beside it: the range is told a little wider, as only nodes of a single value
      // are taken to be constant.
      ValueRange& range = infos[i].ranges.channel[0];
      range.maximum = std::nextafter(range.maximum, std::numeric_limits<float>::infinity());
    }
  }
  return {};
}

Status StoreProducer::produce(const NodeKey& key, std::span<std::byte> voxels) const {
  if (reader_ == nullptr) return Error{"store: the reader is null; expected an open store"};
  GVX_ASSIGN(const store::NodeRecord record, reader_->node(key));
  return reader_->read_brick(key, record, voxels);
}

}  // namespace gvx::produce
