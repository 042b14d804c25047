/// \file
/// StoreWriter: writes bricks, index pages and sections into a .gvx file (docs/store-format.md). The file is
/// called PATH.partial until it is complete and on the disk. Then it is renamed, so a file called PATH is
/// always complete. If PATH is an open file descriptor, such as /dev/fd/5, the store is written there.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "gvx/core/partial_file.h"
#include "gvx/core/result.h"
#include "gvx/store/appended_file.h"
#include "gvx/store/format.h"
#include "gvx/store/index_writer.h"
#include "gvx/store/record_layout.h"

namespace gvx::store {

/// Writes one store. Not thread-safe: the caller decides the order of the bytes. If it is destroyed before
/// finish(), it removes the file.
class StoreWriter {
 public:
  /// Creates the file. An error if that fails, or another process writes the same file.
  static Result<std::unique_ptr<StoreWriter>> create(const std::string& path, const TreeShape& shape,
                                                     const RecordLayout& layout);
  static Result<std::unique_ptr<StoreWriter>> create(const std::string& path, const TreeShape& shape,
                                                     const VoxelFormat& format) {
    return create(path, shape, RecordLayout(format));
  }
  StoreWriter(const StoreWriter&) = delete;
  StoreWriter& operator=(const StoreWriter&) = delete;

  /// The most memory that it needs, in bytes.
  static std::uint64_t most_bytes(const TreeShape& shape) {
    return 2 * AppendedFile::kPendingBytes + IndexWriter::most_bytes(shape);
  }

  /// Appends bytes to which a record or a section will refer. An error after finish().
  Result<BlockRef> add_block(std::span<const std::byte> bytes) { return file_.add_block(bytes); }

  /// Appends a compressed brick. Returns its record, with these ranges.
  Result<NodeRecord> add_brick(std::span<const std::byte> compressed, const ChannelRanges& ranges);

  /// Sets the constant value of all nodes of a level that are in no page. An error once the level has a
  /// page.
  Status set_background(std::uint32_t level, const ChannelRanges& constant);

  /// Adds an index page: 8^3 records in the record layout, x fastest. Records beyond the level's nodes are 0.
  /// The layers of pages of a level come in ascending order of z: an error if one comes too late.
  Status add_page(std::uint32_t level, Vec3i page, std::span<const std::byte> records);

  /// Adds all pages of a level with this z. `records` has pages_x*8 by pages_y*8 by 8 nodes, x fastest.
  Status add_page_layer(std::uint32_t level, std::int64_t page_z, std::span<const NodeRecord> records);

  /// Appends a section. Readers that do not know its name ignore it; if it is `required`, they refuse the
  /// store.
  Status add_section(const std::string& name, std::uint32_t version, bool required,
                     std::span<const std::byte> bytes) {
    return file_.add_section(name, version, required, bytes);
  }

  /// Completes the store: writes the rest of the index, the metadata, the table of sections and the header,
  /// waits for the disk, and renames the file.
  Status finish(const VolumeInfo& info);

  std::uint64_t bytes_written() const { return file_.end(); }

 private:
  StoreWriter(PartialFile file, const TreeShape& shape, const RecordLayout& layout);

  AppendedFile file_;
  TreeShape shape_;
  RecordLayout layout_;
  IndexWriter index_;
};

}  // namespace gvx::store
