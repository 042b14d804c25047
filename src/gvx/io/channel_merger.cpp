#include "gvx/io/channel_merger.h"

#include <algorithm>
#include <cstring>

#include "gvx/io/check_read.h"
#include "gvx/io/header_text.h"

namespace gvx::io {

namespace {

/// Within a voxel at either end, that is: programs round, and scans of one session are a little apart.
bool same_place(const VolumeDescription& a, const VolumeDescription& b) {
  const Affine3 &p = a.voxel_to_world, &q = b.voxel_to_world;
  const double voxel = std::min({length(p.column[0]), length(p.column[1]), length(p.column[2])});
  const Vec3d far(a.dimensions);
  return length(p.origin - q.origin) < voxel && length(p.point(far) - q.point(far)) < voxel;
}

}  // namespace

ChannelMerger::ChannelMerger(std::vector<std::unique_ptr<SliceReader>> channels)
    : channels_(std::move(channels)), description_(channels_.front()->description()) {
  description_.components = static_cast<int>(channels_.size());
  description_.labels = false;
  description_.channels.clear();
  for (const auto& channel : channels_) {
    const auto& described = channel->description().channels;
    if (described.size() == 1) description_.channels.push_back(described.front());
  }
  if (description_.channels.size() != channels_.size()) description_.channels.clear();
}

Result<std::unique_ptr<ChannelMerger>> ChannelMerger::merge(
    std::vector<std::unique_ptr<SliceReader>> channels) {
  const auto missing = [](const auto& channel) { return channel == nullptr; };
  if (channels.empty() || std::any_of(channels.begin(), channels.end(), missing)) {
    return Error{"channels: expected a volume for each"};
  }
  const VolumeDescription& first = channels.front()->description();
  if (channels.size() > 4) return file_error(first.path, "channels: expected at most 4 volumes");
  for (const auto& channel : channels) {
    const VolumeDescription& d = channel->description();
    if (d.components != 1) return file_error(d.path, "channels: expected volumes of one number a voxel");
    if (d.dimensions != first.dimensions || d.type != first.type) {
      return file_error(d.path, "channels: expected the dimensions and sample type of " + first.path);
    }
    if (d.scale != first.scale || d.offset != first.offset || !same_place(d, first)) {
      return file_error(d.path, "channels: expected the place and value scale of " + first.path);
    }
  }
  return std::unique_ptr<ChannelMerger>(new ChannelMerger(std::move(channels)));
}

Status ChannelMerger::read_slices(std::int64_t count, std::span<std::byte> out) {
  GVX_TRY(check_read(*this, count, out));
  const std::size_t width = sample_bytes(description_.type), channels = channels_.size();
  slices_.resize(out.size() / channels);
  for (std::size_t c = 0; c < channels; ++c) {
    GVX_TRY(channels_[c]->read_slices(count, slices_));
    std::byte* to = out.data() + c * width;
    for (std::size_t at = 0; at < slices_.size(); at += width, to += channels * width) {
      std::memcpy(to, slices_.data() + at, width);
    }
  }
  return {};
}

Status ChannelMerger::rewind() {
  for (const auto& channel : channels_) GVX_TRY(channel->rewind());
  return {};
}

std::vector<Surplus> ChannelMerger::surplus() {
  std::vector<Surplus> all;
  for (const auto& channel : channels_) {
    const std::vector<Surplus> of_channel = channel->surplus();
    all.insert(all.end(), of_channel.begin(), of_channel.end());
  }
  return all;
}

bool ChannelMerger::can_rewind() const {
  return std::all_of(channels_.begin(), channels_.end(),
                     [](const auto& channel) { return channel->can_rewind(); });
}

}  // namespace gvx::io
