/// \file
/// StoreWriter puts bricks and index pages into a .gvx file. The file is written under the name PATH.partial
/// and gets its own name when it is whole and on disk, so what is called PATH is always a finished store.
/// Where PATH is that of an open descriptor of a file, such as /dev/fd/5, the store is written there.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/partial_file.h"
#include "gvx/core/result.h"
#include "gvx/store/format.h"

namespace gvx::store {

/// Not thread-safe: its caller decides the order of the bytes. Destroyed before finish(), it removes what it
/// wrote.
class StoreWriter {
 public:
  /// What is written at once; twice as much is held.
  static constexpr std::size_t kPendingBytes = 4 << 20;

  /// An error where the file cannot be made or another process is writing it.
  static Result<std::unique_ptr<StoreWriter>> create(const std::string& path, const TreeShape& shape);
  ~StoreWriter();
  StoreWriter(const StoreWriter&) = delete;
  StoreWriter& operator=(const StoreWriter&) = delete;

  /// Appends a compressed brick; returns its record with these ranges.
  Result<NodeRecord> add_brick(std::span<const std::byte> compressed, const ChannelRanges& ranges);

  /// Appends the pages of one layer of pages of a level. `records`: pages_x*8 by pages_y*8 by 8 nodes, x
  /// fastest.
  Status add_page_layer(std::uint32_t level, std::int64_t page_z, std::span<const NodeRecord> records);

  /// Writes directory, metadata and header, waits for the disk, and gives the file its name.
  Status finish(const VolumeInfo& info);

  std::uint64_t bytes_written() const { return end_; }

 private:
  StoreWriter(PartialFile file, const TreeShape& shape);
  Status append(std::span<const std::byte> bytes);
  Status write_pending();
  Status wait_for_writing();
  Status write_at(std::uint64_t offset, std::span<const std::byte> bytes);

  PartialFile file_;
  std::string partial_path_;  // its name
  int descriptor_;            // of it
  TreeShape shape_;
  std::uint64_t end_ = sizeof(FileHeader);
  std::vector<std::byte> pending_;        // appended, but not written yet: the last before end_
  std::vector<std::byte> being_written_;  // those before them
  std::future<Status> writing_;
  std::vector<PageEntry> directory_;
};

}  // namespace gvx::store
