/// \file
/// StoreReader reads node records and bricks out of a .gvx store, piece by piece and from any number of
/// threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/time_sum.h"
#include "gvx/store/format.h"
#include "gvx/store/range_reader.h"

namespace gvx::store {

/// One page of the index, kPageNodes records.
using IndexPage = std::vector<NodeRecord>;

class StoreReader {
 public:
  /// Reads header, directory and metadata; an error where the file is no whole .gvx store of this version.
  static Result<std::unique_ptr<StoreReader>> open(const std::string& path);

  const VolumeInfo& info() const { return info_; }
  const std::string& path() const { return path_; }

  /// The record of a node that the shape contains. Reads its page where that is not at hand. Thread-safe.
  Result<NodeRecord> node(const NodeKey& key) const;

  /// Fills `voxels`, info().brick_bytes() of them, with a brick; record.constant() needs no file.
  /// Thread-safe.
  Status read_brick(const NodeKey& key, const NodeRecord& record, std::span<std::byte> voxels) const;

  /// Everything that was read from the file so far.
  std::uint64_t bytes_read() const { return bytes_read_.load(std::memory_order_relaxed); }
  /// How long that took, and how long checking and decompressing, of all threads together.
  double reading_milliseconds() const { return reading_.milliseconds(); }
  double decoding_milliseconds() const { return decoding_.milliseconds(); }

 private:
  StoreReader(std::string path, std::unique_ptr<RangeReader> ranges)
      : path_(std::move(path)), ranges_(std::move(ranges)) {}
  Status read_header();
  Status read_metadata(const FileHeader& header);
  Status read_range(std::uint64_t offset, std::span<std::byte> out) const;
  Result<std::shared_ptr<const IndexPage>> page(std::uint64_t index) const;

  std::string path_;
  std::unique_ptr<RangeReader> ranges_;
  VolumeInfo info_;
  std::vector<PageEntry> directory_;
  mutable std::atomic<std::uint64_t> bytes_read_{0};
  mutable TimeSum reading_, decoding_;
  mutable std::mutex pages_mutex_;
  mutable std::unordered_map<std::uint64_t, std::shared_ptr<const IndexPage>> pages_;
};

}  // namespace gvx::store
