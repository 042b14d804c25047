/// \file
/// Files that hold what does not fit memory, and lists of records in them. They have no name, so that nothing
/// is left behind however the program ends (on file systems that must name a file first: unless it is killed
/// in that moment).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "gvx/core/result.h"

namespace gvx::io {

/// Bytes at places, all of one thread.
class ScratchFile {
 public:
  /// Fails where the folder cannot be written to.
  static Result<ScratchFile> create(const std::string& folder);

  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&&) = delete;
  ~ScratchFile();

  /// A name by which this process, and no other, can open the file again as long as this is there.
  std::string path() const;

  /// Fails where the disk is full.
  Status write(std::uint64_t position, std::span<const std::byte> bytes);

  /// Fills `bytes`, all of which must have been written.
  Status read(std::uint64_t position, std::span<std::byte> bytes) const;

 private:
  ScratchFile(std::string folder, int descriptor);

  std::string folder_;
  int descriptor_ = -1;
};

/// Records that are written one behind the other, then read.
template <typename Record>
class ScratchList {
  static_assert(std::is_trivially_copyable_v<Record>);

 public:
  static Result<ScratchList> create(const std::string& folder) {
    GVX_ASSIGN(ScratchFile file, ScratchFile::create(folder));
    return ScratchList(std::move(file));
  }

  std::uint64_t size() const { return written_ + waiting_.size(); }

  Status push(const Record& record) {
    waiting_.push_back(record);
    return waiting_.size() < kMany ? Status() : flush();
  }

  /// To be called after the last push(), before anything is read.
  Status flush() {
    GVX_TRY(file_.write(written_ * sizeof(Record), std::as_bytes(std::span(waiting_))));
    written_ += waiting_.size();
    waiting_.clear();
    return {};
  }

  /// Those from `first` on, as many as `out` takes.
  Status read(std::uint64_t first, std::span<Record> out) const {
    GVX_CHECK(waiting_.empty() && first + out.size() <= written_);
    return file_.read(first * sizeof(Record), std::as_writable_bytes(out));
  }

 private:
  static constexpr std::size_t kMany = (std::size_t{1} << 18) / sizeof(Record);

  explicit ScratchList(ScratchFile file) : file_(std::move(file)) {}

  ScratchFile file_;
  std::uint64_t written_ = 0;
  std::vector<Record> waiting_;
};

/// Reads a part of a list in order, through a buffer.
template <typename Record>
class ScratchReader {
 public:
  ScratchReader(const ScratchList<Record>& list, std::uint64_t first, std::uint64_t count,
                std::size_t buffer_records)
      : list_(&list), next_(first), end_(first + count), most_(buffer_records) {}

  /// The next record, until the next call; null after the last.
  Result<const Record*> next() {
    if (at_ == buffer_.size()) {
      at_ = 0;
      buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(most_, end_ - next_)));
      if (buffer_.empty()) return nullptr;
      GVX_TRY(list_->read(next_, buffer_));
      next_ += buffer_.size();
    }
    return &buffer_[at_++];
  }

 private:
  const ScratchList<Record>* list_;
  std::uint64_t next_, end_;
  std::size_t most_, at_ = 0;
  std::vector<Record> buffer_;
};

}  // namespace gvx::io
