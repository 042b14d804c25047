#include "gvx/produce/production_queue.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <iterator>
#include <limits>
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

/// Of each channel the least and the greatest value; what is no data is neither.
ChannelRanges ranges_in(const TreeDescription& tree, std::span<const std::byte> voxels) {
  ChannelRanges ranges;
  const std::size_t texels = plane_texels(tree.m);
  with_voxel_type(tree.format.type, [&](auto zero) {
    const auto* plane = reinterpret_cast<const decltype(zero)*>(voxels.data());
    for (std::uint32_t c = 0; c < tree.format.channels(); ++c, plane += texels) {
      auto least = std::numeric_limits<decltype(zero)>::max(),
           greatest = std::numeric_limits<decltype(zero)>::lowest();
      for (std::size_t i = 0; i < texels; ++i) {
        least = plane[i] < least ? plane[i] : least;
        greatest = plane[i] > greatest ? plane[i] : greatest;
      }
      ranges.channel[c] = {static_cast<float>(least), static_cast<float>(greatest)};
    }
  });
  return ranges;
}

const exec::Device& host() {
  static const exec::Device device = exec::Device::cpu(1);
  return device;
}

void make_bricks(const Producer& producer, std::span<Produced* const> bricks) {
  const TreeDescription& tree = producer.description();
  const exec::Device device = producer.batching().device.value_or(host());
  const std::size_t bytes = tree.brick_bytes();
  const auto memory = std::make_shared<exec::Buffer<std::byte>>(device, bricks.size() * bytes);
  const std::span<std::byte> voxels(memory->view().data, memory->size());
  std::vector<NodeKey> keys;
  for (const Produced* brick : bricks) keys.push_back(brick->job.key);
  std::vector<std::optional<ChannelRanges>> constants(keys.size());
  const Status status = producer.produce_batch({keys, voxels, constants});
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    Produced& brick = *bricks[i];
    brick.status = status;
    brick.memory = memory;
    brick.voxels = voxels.subspan(i * bytes, bytes);
    const bool here = device.kind() == exec::DeviceKind::cpu;
    if (status.ok() && here && !tree.exact_ranges && tree.format.content == VoxelContent::scalar) {
      brick.found = ranges_in(tree, brick.voxels);
    }
    const bool may_be_constant =
        keys[i].level == tree.max_level && !tree.exact_ranges && tree.format.planes == 1;
    if (!status.ok() || !may_be_constant) continue;
    brick.constant = constants[i];
    if (!brick.constant && here) {
      const std::size_t plane = plane_texels(tree.m) * voxel_bytes(tree.format.type);
      brick.constant = single_value(tree.format.type, brick.voxels.first(plane));
    }
  }
}

void describe_children(const Producer& producer, std::span<Produced* const> parents) {
  const int n = static_cast<int>(producer.description().n);
  const auto count = static_cast<std::size_t>(n) * n * n;
  std::vector<NodeKey> keys;
  for (const Produced* parent : parents) {
    for (std::size_t i = 0; i < count; ++i) {
      keys.push_back(producer.canonical(child(parent->job.key, n, static_cast<int>(i))));
    }
  }
  std::vector<tree::NodeInfo> infos(keys.size());
  const Status status = producer.describe(keys, infos);
  for (std::size_t p = 0; p < parents.size(); ++p) {
    const std::span of_keys = std::span(keys).subspan(p * count, count);
    const std::span of_infos = std::span(infos).subspan(p * count, count);
    parents[p]->status = status;
    parents[p]->child_keys.assign(of_keys.begin(), of_keys.end());
    parents[p]->children.assign(of_infos.begin(), of_infos.end());
  }
}

/// Does the jobs of one kind.
template <typename Work>
void do_jobs(JobKind kind, std::vector<Produced>& all, Work work) {
  std::vector<Produced*> produced;
  for (Produced& p : all) {
    if (p.job.kind == kind) produced.push_back(&p);
  }
  if (produced.empty()) return;
  const auto fail = [&](const std::string& why) {
    for (Produced* p : produced) p->status = Error{why};
  };
  try {
    work(produced);
  } catch (const std::bad_alloc&) {
    fail("out of memory");
  } catch (const std::exception& error) {
    fail(std::string("a producer failed: ") + error.what());
  }
}

}  // namespace

std::vector<Produced> make(const Producer& producer, std::span<const Job> jobs) {
  std::vector<Produced> all;
  for (const Job& job : jobs) all.push_back({job, {}, {}, {}, {}, {}, {}, {}});
  do_jobs(JobKind::brick, all, [&](std::span<Produced* const> bricks) { make_bricks(producer, bricks); });
  do_jobs(JobKind::children, all,
          [&](std::span<Produced* const> parents) { describe_children(producer, parents); });
  return all;
}

Produced make(const Producer& producer, const Job& job) {
  return std::move(make(producer, std::span(&job, 1)).front());
}

ProductionQueue::ProductionQueue(std::shared_ptr<const Producer> producer, int threads)
    : producer_(std::move(producer)),
      thread_count_(static_cast<std::size_t>(threads)),
      most_in_batch_(std::max<std::size_t>(producer_->batching().most, 1)) {
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

/// No more than the thread's share: what is most urgent is begun by all threads at once.
std::vector<Job> ProductionQueue::take_waiting() {
  const std::size_t share = waiting_.size() / thread_count_;
  const auto count = static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(share, 1, most_in_batch_));
  std::vector<Job> jobs(waiting_.rbegin(), waiting_.rbegin() + count);
  waiting_.erase(waiting_.end() - count, waiting_.end());
  return jobs;
}

void ProductionQueue::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    work_came_.wait(lock, [&] { return stopping_ || !waiting_.empty(); });
    if (stopping_) return;
    const std::vector<Job> jobs = take_waiting();
    under_way_.insert(jobs.begin(), jobs.end());
    ++making_;
    lock.unlock();
    std::vector<Produced> produced;
    {
      const TimeSum::Span making(making_time_);
      produced = produce::make(*producer_, jobs);
    }
    lock.lock();
    --making_;
    std::move(produced.begin(), produced.end(), std::back_inserter(finished_));
    work_done_.notify_all();
  }
}

}  // namespace gvx::produce
