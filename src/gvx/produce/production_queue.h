/// \file
/// ProductionQueue runs a producer beside rendering, on threads of its own: reading, decoding and describing
/// happen there; committing what is finished is the engine's.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <unordered_set>
#include <vector>

#include "gvx/core/time_sum.h"
#include "gvx/exec/buffer.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

enum class JobKind : std::uint32_t { brick, children };

/// Make the brick of a canonical node, or describe its N^3 children.
struct Job {
  NodeKey key;
  JobKind kind = JobKind::brick;

  constexpr bool operator==(const Job&) const = default;
};

struct JobHash {
  std::size_t operator()(const Job& job) const {
    return NodeKeyHash{}(job.key) * 2 + static_cast<std::size_t>(job.kind);
  }
};

/// What came of a job.
struct Produced {
  Job job;
  Status status;
  std::span<const std::byte> voxels;                      ///< of a brick
  std::shared_ptr<const exec::Buffer<std::byte>> memory;  ///< that holds them
  std::optional<ChannelRanges> constant;  ///< the one value of a brick that turned out to have but one
  /// Of all values of a brick of scalars, border and all, in a host's memory; not of a tree of exact ranges.
  std::optional<ChannelRanges> found;
  std::vector<NodeKey> child_keys;       ///< of children: canonical
  std::vector<tree::NodeInfo> children;  ///< of children: N^3 of them
};

/// Does jobs together, on the calling thread; what the producer throws becomes an error, and an error is one
/// of all bricks or of all children. A brick of one value is a constant only where nothing is below it: the
/// flat mean of a sub-tree says nothing of the sub-tree.
std::vector<Produced> make(const Producer& producer, std::span<const Job> jobs);
Produced make(const Producer& producer, const Job& job);

class ProductionQueue {
 public:
  ProductionQueue(std::shared_ptr<const Producer> producer, int threads);
  ~ProductionQueue();
  ProductionQueue(const ProductionQueue&) = delete;
  ProductionQueue& operator=(const ProductionQueue&) = delete;

  /// Replaces the jobs that have not begun by these, the most urgent first. Jobs that are being made or wait
  /// to be taken are not made again.
  void replace(const std::vector<Job>& jobs);

  /// What is finished, in the order of finishing. Does not wait.
  std::vector<Produced> take_finished();

  /// Waits until something is finished or nothing is left to do.
  void wait();

  /// The same, but no longer than until `deadline`.
  void wait_until(std::chrono::steady_clock::time_point deadline);

  /// Is nothing waiting, being made, or finished?
  bool idle() const;

  /// How long threads have been making jobs, all of them together.
  double making_milliseconds() const { return making_time_.milliseconds(); }

 private:
  void work();
  std::vector<Job> take_waiting();

  std::shared_ptr<const Producer> producer_;
  std::size_t thread_count_, most_in_batch_;
  mutable std::mutex mutex_;
  std::condition_variable work_came_, work_done_;
  std::vector<Job> waiting_;                    // the most urgent last
  std::unordered_set<Job, JobHash> under_way_;  // being made, or finished and not yet taken
  std::vector<Produced> finished_;
  std::size_t making_ = 0;
  TimeSum making_time_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace gvx::produce
