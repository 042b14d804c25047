/// \file
/// IndexWriter makes the tree of pages over the records of each level. It holds the references to the pages
/// of eight layers, of each height, and no more:
///
///     height 0   [ 8 layers of pages of records ] -> pages of references -> writer
///     height 1   [ 8 layers of those ]            -> ...
///     top        one page
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/format.h"
#include "gvx/store/record_layout.h"

namespace gvx::store {

/// Used by one thread.
class IndexWriter {
 public:
  /// Appends bytes to the file; says where they are.
  using Append = std::function<Result<BlockRef>(std::span<const std::byte>)>;

  IndexWriter(const TreeShape& shape, const RecordLayout& layout, Append append);

  /// The memory that it takes at most.
  static std::uint64_t most_bytes(const TreeShape& shape);

  /// The record of all nodes of a level whose page nobody adds: a constant one. Before the level's first
  /// page.
  Status set_background(std::uint32_t level, std::span<const std::byte> record);

  /// A page of 8^3 records, x fastest; those beyond the level's nodes are 0. Of a level the layers of pages
  /// come in order; within eight of them the order is free.
  Status add_page(std::uint32_t level, Vec3i page, std::span<const std::byte> records);

  /// Writes what is left; the top page of each level.
  Result<std::vector<PageRef>> finish();

 private:
  /// References to the pages of one height: of the block of eight layers that is being filled.
  struct Height {
    Vec3i pages;
    std::int64_t block = 0;
    bool begun = false;  ///< does the block hold a reference that was put there?
    std::vector<PageRef> refs;
  };
  struct Level {
    std::vector<Height> heights;  ///< those below the top
    PageRef background{}, top{};
  };

  Result<PageRef> page_of_one_record(std::span<const std::byte> record);
  /// Of a page whose nodes all have one record that is constant: this record; else none.
  std::span<const std::byte> one_record(std::uint32_t level, Vec3i page,
                                        std::span<const std::byte> records) const;
  Status put(std::uint32_t level, std::uint32_t height, Vec3i page, const PageRef& ref);
  Status write_blocks(std::uint32_t level, std::uint32_t height, std::int64_t end);
  Status write_block(std::uint32_t level, std::uint32_t height);
  Result<PageRef> page_above(const Height& h, std::int64_t x, std::int64_t y);
  Result<PageRef> write_page(std::size_t element_bytes, std::span<const std::byte> raw);

  const TreeShape shape_;
  const RecordLayout layout_;
  const Append append_;
  std::vector<Level> levels_;
  std::vector<std::byte> compressed_;
  std::vector<std::byte> last_record_;  // that was written alone, and where
  PageRef last_ref_{};
};

}  // namespace gvx::store
