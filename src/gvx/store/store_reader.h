/// \file
/// StoreReader: reads parts of a .gvx store, the file format of docs/store-format.md. A store holds a volume
/// as bricks, small cubes of voxels, and a record for each: where it is, and which values it holds. Several
/// threads can read at once.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/format.h"
#include "gvx/store/page_index.h"
#include "gvx/store/sections.h"
#include "gvx/store/store_file.h"

namespace gvx::store {

/// An open store.
class StoreReader {
 public:
  /// Opens a store. Of version 3 this reads a few kilobytes, whatever the store's size: the header, the table
  /// of sections, the directory and the metadata. An error if the file is not a complete .gvx store of a
  /// known version.
  static Result<std::unique_ptr<StoreReader>> open(const std::string& path);

  const VolumeInfo& info() const { return info_; }
  const std::string& path() const { return file_.path(); }
  /// The version of the file's format.
  std::uint32_t version() const { return version_; }
  /// All sections of the file, including unknown ones.
  const std::vector<Section>& sections() const { return sections_; }

  /// The record of a node; an error if there is none. Reads index pages that are not in memory. Thread-safe.
  Result<NodeRecord> node(const NodeKey& key) const;

  /// Fills `voxels`, info().brick_bytes(border) bytes, with the brick of a node. If record.constant(),
  /// nothing is read. If the store's border is narrower than `border` (1 or 2), outer voxels are
  /// extrapolated. Thread-safe.
  Status read_brick(const NodeKey& key, const NodeRecord& record, std::span<std::byte> voxels,
                    std::uint32_t border = kBrickBorder) const;

  const PageIndex& index() const { return *index_; }
  const StoreFile& file() const { return file_; }

  /// Bytes read from the file so far.
  std::uint64_t bytes_read() const { return file_.bytes_read(); }
  /// Time for reading, and for checking and decompressing; summed over all threads.
  double reading_milliseconds() const { return file_.reading_milliseconds(); }
  double decoding_milliseconds() const { return file_.decoding().milliseconds(); }

 private:
  StoreReader(std::string path, std::unique_ptr<RangeReader> ranges)
      : file_(std::move(path), std::move(ranges)) {}
  Status read_all_but_bricks();
  Status read_metadata();
  Status read_stored(const NodeKey& key, const NodeRecord& record, std::span<std::byte> voxels) const;

  StoreFile file_;
  std::uint32_t version_ = 0;
  VolumeInfo info_;
  std::vector<Section> sections_;
  std::unique_ptr<PageIndex> index_;
};

}  // namespace gvx::store
