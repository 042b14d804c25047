#include "gvx/produce/production_queue.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <utility>

namespace gvx::produce {
namespace {

/// The one value of all voxels, if they have but one.
std::optional<ChannelRanges> single_value(VoxelType type, std::span<const std::byte> voxels) {
  const std::size_t element = voxel_bytes(type);
  // Equal to itself shifted by one voxel: all are equal.
  if (std::memcmp(voxels.data(), voxels.data() + element, voxels.size() - element) != 0) return std::nullopt;
  return with_voxel_type(type, [&](auto value) {
    std::memcpy(&value, voxels.data(), element);
    const auto v = static_cast<float>(value);
    return std::optional<ChannelRanges>(ValueRange{v, v});
  });
}

void do_job(const Producer& producer, Produced& produced) {
  const TreeDescription& tree = producer.description();
  const NodeKey& key = produced.job.key;
  if (produced.job.kind == JobKind::brick) {
    produced.voxels.resize(tree.brick_bytes());
    produced.status = producer.produce(key, produced.voxels);
    const bool may_be_constant = key.level == tree.max_level && !tree.exact_ranges && tree.format.planes == 1;
    if (produced.status.ok() && may_be_constant) {
      const std::size_t bytes = plane_texels(tree.m) * voxel_bytes(tree.format.type);
      produced.constant = single_value(tree.format.type, std::span(produced.voxels).first(bytes));
    }
  } else {
    const int n = static_cast<int>(tree.n);
    for (int i = 0; i < n * n * n; ++i) produced.child_keys.push_back(producer.canonical(child(key, n, i)));
    produced.children.resize(produced.child_keys.size());
    produced.status = producer.describe(produced.child_keys, produced.children);
  }
}

}  // namespace

Produced make(const Producer& producer, const Job& job) {
  Produced produced{job, {}, {}, {}, {}, {}};
  try {
    do_job(producer, produced);
  } catch (const std::bad_alloc&) {
    produced.status = Error{"out of memory"};
  } catch (const std::exception& error) {
    produced.status = Error{std::string("a producer failed: ") + error.what()};
  }
  return produced;
}

ProductionQueue::ProductionQueue(std::shared_ptr<const Producer> producer, int threads)
    : producer_(std::move(producer)) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

ProductionQueue::~ProductionQueue() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  work_came_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void ProductionQueue::replace(const std::vector<Job>& jobs) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
    std::unordered_set<Job, JobHash> listed;
    for (const Job& job : jobs) {
      if (!under_way_.contains(job) && listed.insert(job).second) waiting_.push_back(job);
    }
    std::reverse(waiting_.begin(), waiting_.end());
  }
  work_came_.notify_all();
}

std::vector<Produced> ProductionQueue::take_finished() {
  const std::lock_guard lock(mutex_);
  for (const Produced& produced : finished_) under_way_.erase(produced.job);
  return std::exchange(finished_, {});
}

void ProductionQueue::wait() {
  std::unique_lock lock(mutex_);
  work_done_.wait(lock, [&] { return !finished_.empty() || (waiting_.empty() && making_ == 0); });
}

void ProductionQueue::wait_until(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock lock(mutex_);
  work_done_.wait_until(lock, deadline,
                        [&] { return !finished_.empty() || (waiting_.empty() && making_ == 0); });
}

bool ProductionQueue::idle() const {
  const std::lock_guard lock(mutex_);
  return waiting_.empty() && making_ == 0 && finished_.empty();
}

void ProductionQueue::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    work_came_.wait(lock, [&] { return stopping_ || !waiting_.empty(); });
    if (stopping_) return;
    const Job job = waiting_.back();
    waiting_.pop_back();
    under_way_.insert(job);
    ++making_;
    lock.unlock();
    Produced produced;
    {
      const TimeSum::Span making(making_time_);
      produced = produce::make(*producer_, job);
    }
    lock.lock();
    --making_;
    finished_.push_back(std::move(produced));
    work_done_.notify_all();
  }
}

}  // namespace gvx::produce
