#include "gvx/exec/device.h"

#include <algorithm>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "gvx/exec/cuda_support.h"

namespace gvx::exec {
namespace {

constexpr int kMostThreads = 1024;

}  // namespace

Device Device::cpu(int threads) {
  const int count = threads > 0 ? threads : tbb::info::default_concurrency();
  // oneTBB caps all arenas together at the machine's cores; a larger wish (tests of races) must lift that
  // cap.
  static tbb::global_control cap(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(kMostThreads, tbb::info::default_concurrency())));
  return Device(DeviceKind::cpu, count, std::make_shared<tbb::task_arena>(count));
}

Result<Device> Device::cuda() {
  GVX_ASSIGN(const int count, cuda_support::device_count());
  if (count == 0) return Error{"no CUDA device: this machine has none"};
  return Device(DeviceKind::cuda, 1, nullptr);
}

std::vector<Device> Device::all() {
  std::vector<Device> devices = {cpu()};
  if (auto gpu = cuda(); gpu.ok()) devices.push_back(std::move(gpu).value());
  return devices;
}

std::string Device::name() const {
  if (kind_ == DeviceKind::cuda) return cuda_support::device_name();
  return "cpu, " + std::to_string(threads_) + (threads_ == 1 ? " thread" : " threads");
}

tbb::task_arena& Device::arena() const {
  GVX_CHECK(arena_ != nullptr);
  return *arena_;
}

void Device::synchronize() const {
  if (kind_ == DeviceKind::cuda) cuda_support::synchronize("synchronize");
}

}  // namespace gvx::exec
