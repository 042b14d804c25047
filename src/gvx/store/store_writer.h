/// \file
/// StoreWriter puts bricks, index pages and sections into a .gvx file. The file is written under the name
/// PATH.partial and gets its own name when it is whole and on disk, so what is called PATH is always a
/// finished store. Where PATH is that of an open descriptor of a file, such as /dev/fd/5, the store is
/// written there.
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
#include "gvx/store/index_writer.h"
#include "gvx/store/record_layout.h"

namespace gvx::store {

/// Not thread-safe: its caller decides the order of the bytes. Destroyed before finish(), it removes what it
/// wrote.
class StoreWriter {
 public:
  /// What is written at once; twice as much is held.
  static constexpr std::size_t kPendingBytes = 4 << 20;

  /// An error where the file cannot be made or another process is writing it.
  static Result<std::unique_ptr<StoreWriter>> create(const std::string& path, const TreeShape& shape,
                                                     const RecordLayout& layout);
  static Result<std::unique_ptr<StoreWriter>> create(const std::string& path, const TreeShape& shape,
                                                     const VoxelFormat& format) {
    return create(path, shape, RecordLayout(format));
  }
  ~StoreWriter();
  StoreWriter(const StoreWriter&) = delete;
  StoreWriter& operator=(const StoreWriter&) = delete;

  /// The memory that it takes at most.
  static std::uint64_t most_bytes(const TreeShape& shape) {
    return 2 * kPendingBytes + IndexWriter::most_bytes(shape);
  }

  /// Appends bytes that a record or a section will refer to.
  Result<BlockRef> add_block(std::span<const std::byte> bytes);

  /// Appends a compressed brick; returns its record with these ranges.
  Result<NodeRecord> add_brick(std::span<const std::byte> compressed, const ChannelRanges& ranges);

  /// What all nodes of a level are whose page nobody adds: constant. Before the level's first page.
  Status set_background(std::uint32_t level, const ChannelRanges& constant);

  /// Adds a page of 8^3 records, x fastest, as the layout has them; those beyond the level's nodes are 0. Of
  /// a level the layers of pages come in order.
  Status add_page(std::uint32_t level, Vec3i page, std::span<const std::byte> records);

  /// Adds the pages of one layer of pages of a level. `records`: pages_x*8 by pages_y*8 by 8 nodes, x
  /// fastest.
  Status add_page_layer(std::uint32_t level, std::int64_t page_z, std::span<const NodeRecord> records);

  /// Appends a section that readers ignore if they do not know its name, or, if it is required, refuse the
  /// store.
  Status add_section(const std::string& name, std::uint32_t version, bool required,
                     std::span<const std::byte> bytes);

  /// Writes the rest of the index, metadata, table of sections and header, waits for the disk, and gives the
  /// file its name.
  Status finish(const VolumeInfo& info);

  std::uint64_t bytes_written() const { return end_; }

 private:
  StoreWriter(PartialFile file, const TreeShape& shape, const RecordLayout& layout);
  Status append(std::span<const std::byte> bytes);
  Status write_pending();
  Status wait_for_writing();
  Status write_at(std::uint64_t offset, std::span<const std::byte> bytes);

  PartialFile file_;
  std::string partial_path_;  // its name
  int descriptor_;            // of it
  TreeShape shape_;
  RecordLayout layout_;
  IndexWriter index_;
  std::uint64_t end_ = sizeof(FileHeader);
  std::vector<std::byte> pending_;        // appended, but not written yet: the last before end_
  std::vector<std::byte> being_written_;  // those before them
  std::future<Status> writing_;
  std::vector<Section> sections_;
};

}  // namespace gvx::store
