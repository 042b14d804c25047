/// \file
/// ChannelMerger: several volumes of the same shape as one whose voxels have a component from each, as
/// microscopes write one file a channel.
#pragma once

#include <memory>
#include <vector>

#include "gvx/io/volume_reader.h"

namespace gvx::io {

class ChannelMerger final : public SliceReader {
 public:
  /// Up to four volumes of one component; an error that names the first whose dimensions, sample type, value
  /// scale or place (to a voxel) are not those of the first.
  static Result<std::unique_ptr<ChannelMerger>> merge(std::vector<std::unique_ptr<SliceReader>> channels);

  const VolumeDescription& description() const override { return description_; }
  Status read_slices(std::int64_t count, std::span<std::byte> out) override;
  std::int64_t next_slice() const override { return channels_.front()->next_slice(); }
  Status rewind() override;
  bool can_rewind() const override;
  std::vector<Surplus> surplus() override;

 private:
  explicit ChannelMerger(std::vector<std::unique_ptr<SliceReader>> channels);

  std::vector<std::unique_ptr<SliceReader>> channels_;
  VolumeDescription description_;
  std::vector<std::byte> slices_;
};

}  // namespace gvx::io
