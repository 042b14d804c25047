/// \file
/// StoreReader reads node records and bricks out of a .gvx store, piece by piece and from any number of
/// threads.
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

class StoreReader {
 public:
  /// Reads header, sections' table, directory and metadata: of version 3 a few kilobytes, whatever the
  /// store's size. An error where the file is no whole .gvx store of a version that this program reads.
  static Result<std::unique_ptr<StoreReader>> open(const std::string& path);

  const VolumeInfo& info() const { return info_; }
  const std::string& path() const { return file_.path(); }
  /// Of the file's format.
  std::uint32_t version() const { return version_; }
  /// All that the file has, also those that this program does not know.
  const std::vector<Section>& sections() const { return sections_; }

  /// The record of a node that the shape contains. Reads its pages where they are not at hand. Thread-safe.
  Result<NodeRecord> node(const NodeKey& key) const;

  /// Fills `voxels`, info().brick_bytes(border) of them, with a brick; record.constant() needs no file. Where
  /// the store's border is less than what is asked for, it is extrapolated. Thread-safe.
  Status read_brick(const NodeKey& key, const NodeRecord& record, std::span<std::byte> voxels,
                    std::uint32_t border = kBrickBorder) const;

  const PageIndex& index() const { return *index_; }
  const StoreFile& file() const { return file_; }

  /// Everything that was read from the file so far.
  std::uint64_t bytes_read() const { return file_.bytes_read(); }
  /// How long that took, and how long checking and decompressing, of all threads together.
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
