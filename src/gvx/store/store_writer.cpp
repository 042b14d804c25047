#include "gvx/store/store_writer.h"

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include "gvx/store/codec.h"

namespace gvx::store {

StoreWriter::StoreWriter(PartialFile file, const TreeShape& shape)
    : file_(std::move(file)),
      partial_path_(file_.name()),
      descriptor_(file_.descriptor()),
      shape_(shape),
      directory_(shape.pages_before(shape.levels)) {}

StoreWriter::~StoreWriter() {
  (void)wait_for_writing();
}

Result<std::unique_ptr<StoreWriter>> StoreWriter::create(const std::string& path, const TreeShape& shape) {
  GVX_ASSIGN(PartialFile file, PartialFile::create(path));
  return std::unique_ptr<StoreWriter>(new StoreWriter(std::move(file), shape));
}

Status StoreWriter::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return Error{partial_path_ + ": cannot write: " + std::strerror(errno)};
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

Status StoreWriter::append(std::span<const std::byte> bytes) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  end_ += bytes.size();
  return pending_.size() < kPendingBytes ? Status() : write_pending();
}

/// Has what was appended written while the caller goes on; an error of what was written before.
Status StoreWriter::write_pending() {
  GVX_TRY(wait_for_writing());
  std::swap(pending_, being_written_);
  pending_.clear();
  const std::uint64_t start = end_ - being_written_.size();
  writing_ = std::async(std::launch::async, [this, start]() -> Status {
    GVX_TRY(write_at(start, being_written_));
    // Waiting for the disk here, beside the caller's work, leaves little to wait for at the end: a device
    // flushes its own cache for as long as there is data in it.
    if (fdatasync(descriptor_) != 0) return Error{partial_path_ + ": cannot write: " + std::strerror(errno)};
    return {};
  });
  return {};
}

Status StoreWriter::wait_for_writing() {
  return writing_.valid() ? writing_.get() : Status();
}

Result<NodeRecord> StoreWriter::add_brick(std::span<const std::byte> compressed,
                                          const ChannelRanges& ranges) {
  const NodeRecord record{end_, static_cast<std::uint32_t>(compressed.size()),
                          static_cast<std::uint32_t>(checksum(compressed)), ranges};
  GVX_TRY(append(compressed));
  return record;
}

Status StoreWriter::add_page_layer(std::uint32_t level, std::int64_t page_z,
                                   std::span<const NodeRecord> records) {
  const Vec3i pages = shape_.level_pages(level);
  const std::int64_t row = pages.x * kPageEdge, slice = row * pages.y * kPageEdge;
  GVX_CHECK(static_cast<std::int64_t>(records.size()) == slice * kPageEdge);
  std::vector<NodeRecord> page(kPageNodes);
  std::vector<std::byte> compressed;
  for (std::int64_t py = 0; py < pages.y; ++py) {
    for (std::int64_t px = 0; px < pages.x; ++px) {
      for (std::int64_t z = 0; z < kPageEdge; ++z) {
        for (std::int64_t y = 0; y < kPageEdge; ++y) {
          const auto from = records.begin() + z * slice + (py * kPageEdge + y) * row + px * kPageEdge;
          std::copy(from, from + kPageEdge, page.begin() + (z * kPageEdge + y) * kPageEdge);
        }
      }
      compress(Codec::zstd, {sizeof(NodeRecord), kPageNodes}, std::as_bytes(std::span(page)), compressed);
      const std::uint64_t index =
          shape_.pages_before(level) + static_cast<std::uint64_t>((page_z * pages.y + py) * pages.x + px);
      directory_[index] = {end_, static_cast<std::uint32_t>(compressed.size()),
                           static_cast<std::uint32_t>(checksum(compressed))};
      GVX_TRY(append(compressed));
    }
  }
  return {};
}

Status StoreWriter::finish(const VolumeInfo& info) {
  FileHeader header{};
  header.magic = kMagic;
  header.version = kVersion;
  header.header_bytes = sizeof(FileHeader);
  header.n = shape_.n;
  header.m = shape_.m;
  header.voxel_type = static_cast<std::uint32_t>(info.format.type);
  header.content = static_cast<std::uint32_t>(info.format.content);
  header.planes = info.format.planes;
  header.codec = static_cast<std::uint32_t>(info.codec);
  for (int axis = 0; axis < 3; ++axis) {
    header.dimensions[axis] = static_cast<std::uint64_t>(shape_.dimensions[axis]);
  }
  header.levels = shape_.levels;
  header.page_edge = kPageEdge;
  for (int i = 0; i < 12; ++i) {
    header.voxel_to_world[i] =
        i < 9 ? info.voxel_to_world.column[i / 3][i % 3] : info.voxel_to_world.origin[i % 3];
  }
  header.scale = info.scale;
  header.offset = info.offset;
  header.range = info.ranges.channel[0];

  const auto directory = std::as_bytes(std::span(directory_));
  header.directory_offset = end_;
  header.directory_bytes = directory.size();
  header.directory_checksum = checksum(directory);
  GVX_TRY(append(directory));

  nlohmann::json channels = nlohmann::json::array();
  for (std::uint32_t c = 0; c < info.format.channels(); ++c) {
    const ValueRange range = info.ranges.channel[c];
    channels.push_back({{"range", {range.minimum, range.maximum}}, {"histogram", info.histograms.at(c)}});
  }
  const nlohmann::json metadata = {
      {"source", info.source}, {"anatomical", info.anatomical}, {"channels", channels}};
  const std::string text = metadata.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  const auto text_bytes = std::as_bytes(std::span(text));
  header.metadata_offset = end_;
  header.metadata_bytes = text.size();
  header.metadata_checksum = checksum(text_bytes);
  GVX_TRY(append(text_bytes));

  GVX_TRY(write_pending());
  GVX_TRY(wait_for_writing());
  header.file_bytes = end_;
  const auto header_bytes = std::as_bytes(std::span(&header, 1));
  header.header_checksum = checksum(header_bytes.first(offsetof(FileHeader, header_checksum)));
  GVX_TRY(write_at(0, header_bytes));

  if (fsync(descriptor_) != 0) return Error{partial_path_ + ": cannot write: " + std::strerror(errno)};
  return file_.commit();
}

}  // namespace gvx::store
