/// \file
/// PageIndex finds the record of a node in a store's index: by a walk down the tree of its level's pages, or,
/// in a store of version 2, in a directory of all pages that is held whole.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/format.h"
#include "gvx/store/header.h"
#include "gvx/store/page_cache.h"
#include "gvx/store/record_layout.h"
#include "gvx/store/store_file.h"

namespace gvx::store {

/// Thread-safe.
class PageIndex {
 public:
  /// The bound of the pages that are kept, unless another is set: the records of five million nodes of one
  /// channel.
  static constexpr std::size_t kCacheBytes = 64 << 20;

  /// Reads the section "directory" and, where there is one, "records". `file` must outlive the index.
  static Result<std::unique_ptr<PageIndex>> open(const StoreFile& file, const StoreHeader& header);

  const RecordLayout& layout() const { return layout_; }

  /// The record of a node that the shape contains.
  Result<NodeRecord> node(const NodeKey& key) const;

  /// The bytes of that record.
  struct Record {
    Page page;
    const std::byte* bytes;
    bool of_many;  ///< does it stand for all nodes of a page or more?
  };
  Result<Record> record(const NodeKey& key) const;

  /// What for_each_page() finds: the nodes of a box that one page holds, or that share one record.
  struct Part {
    NodeBox nodes;
    bool one_record;
    /// Bytes of all pages visited so far, this one included. Pages of one record do not count, as many
    /// references may share one.
    std::uint64_t page_bytes;
  };
  /// Calls take(part) for parts that make up the nodes of a box. Ends with the first error of take().
  using Take = std::function<Status(const Part&)>;
  Status for_each_page(const NodeBox& box, const Take& take) const;

  /// Bytes that the kept pages take.
  std::size_t cached_bytes() const { return cache_.bytes(); }
  /// Bytes that all pages would take; at most kCacheBytes.
  std::size_t wanted_bytes() const;
  /// Keeps pages of at most so many bytes from now on.
  void keep_at_most(std::size_t bytes) const { cache_.set_bound(bytes); }

 private:
  PageIndex(const StoreFile& file, const TreeShape& shape, RecordLayout layout);
  Status read_directory(const StoreHeader& header);
  PageRef flat_page(std::uint32_t level, Vec3i page) const;
  /// Page `page` of a height of a level.
  Result<Page> load(const PageRef& ref, std::uint32_t level, std::uint32_t height, Vec3i page) const;
  Status walk(const PageRef& ref, std::uint32_t height, Vec3i page, const NodeBox& box,
              std::uint64_t& page_bytes, const Take& take) const;

  struct Level {
    std::uint32_t height = 0;  ///< of the top page
    Vec3i pages;               ///< that hold records
    std::uint64_t first = 0;   ///< of them in the flat directory
  };

  const StoreFile& file_;
  const TreeShape shape_;
  const RecordLayout layout_;
  std::vector<Level> levels_;
  bool flat_ = false;
  /// The top page of each level; where flat_, all pages that hold records.
  std::vector<PageRef> directory_;
  mutable PageCache cache_{kCacheBytes};
};

}  // namespace gvx::store
