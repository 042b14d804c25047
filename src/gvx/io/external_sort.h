/// \file
/// ExternalSorter: sorts records of which more come than memory holds. As many as fit are sorted and written
/// to a scratch file as a run; at last all runs are merged (Knuth, The Art of Computer Programming 3, 5.4).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/scratch_file.h"

namespace gvx::io {

/// Less must order all records: of equal ones any may come first.
template <typename Record, typename Less>
class ExternalSorter {
 public:
  /// For no more than `expected` records. A scratch file stands in `folder`, and is only made where
  /// memory_bytes do not suffice.
  ExternalSorter(std::string folder, std::uint64_t memory_bytes, std::uint64_t expected, Less less)
      : folder_(std::move(folder)),
        most_(static_cast<std::size_t>(
            std::max<std::uint64_t>(std::min(memory_bytes / sizeof(Record), expected + 1), 2))),
        less_(less) {}

  Status push(const Record& record) {
    // Pages that are not touched take no memory; growing by doubling would take half as much again.
    if (run_.capacity() == 0) run_.reserve(most_);
    run_.push_back(record);
    return run_.size() < most_ ? Status() : end_run();
  }

  /// Calls function(record) for all of them in order; it returns a Status. Nothing can be pushed afterwards.
  template <typename Function>
  Status for_each(const Function& function) {
    if (!runs_) {
      std::sort(run_.begin(), run_.end(), less_);
      for (const Record& record : run_) GVX_TRY(function(record));
      return {};
    }
    GVX_TRY(end_run());
    run_ = std::vector<Record>();
    return merge(function);
  }

 private:
  Status end_run() {
    std::sort(run_.begin(), run_.end(), less_);
    if (!runs_) {
      GVX_ASSIGN(auto runs, ScratchList<Record>::create(folder_));
      runs_.emplace(std::move(runs));
    }
    for (const Record& record : run_) GVX_TRY(runs_->push(record));
    GVX_TRY(runs_->flush());
    ends_.push_back(runs_->size());
    run_.clear();
    return {};
  }

  template <typename Function>
  Status merge(const Function& function) {
    struct Head {
      const Record* record;
      std::size_t run;
    };
    const std::size_t buffer = std::max<std::size_t>(most_ / ends_.size(), 16);
    std::vector<ScratchReader<Record>> readers;
    std::vector<Head> heads;
    for (std::size_t r = 0; r < ends_.size(); ++r) {
      const std::uint64_t begin = r > 0 ? ends_[r - 1] : 0;
      readers.emplace_back(*runs_, begin, ends_[r] - begin, buffer);
      GVX_ASSIGN(const Record* first, readers[r].next());
      if (first != nullptr) heads.push_back({first, r});
    }
    const auto later = [&](const Head& a, const Head& b) { return less_(*b.record, *a.record); };
    std::make_heap(heads.begin(), heads.end(), later);
    while (!heads.empty()) {
      std::pop_heap(heads.begin(), heads.end(), later);
      Head& head = heads.back();
      GVX_TRY(function(*head.record));
      GVX_ASSIGN(head.record, readers[head.run].next());
      if (head.record != nullptr) {
        std::push_heap(heads.begin(), heads.end(), later);
      } else {
        heads.pop_back();
      }
    }
    return {};
  }

  std::string folder_;
  std::size_t most_;
  Less less_;
  std::vector<Record> run_;                  // what is in memory
  std::optional<ScratchList<Record>> runs_;  // one behind the other
  std::vector<std::uint64_t> ends_;          // of each run
};

}  // namespace gvx::io
