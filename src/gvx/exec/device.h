/// \file
/// Device: where work runs. An argument of every operation, never a global. A device that this build or this
/// machine lacks is an error when it is asked for; nothing falls back in silence.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gvx/core/result.h"

namespace tbb::detail::d1 {
class task_arena;
}

namespace gvx::exec {

enum class DeviceKind { cpu, cuda };

/// A handle to a CPU thread pool or a CUDA GPU; copies share it.
class Device {
 public:
  /// The CPU with this many threads; 0 takes all that the process may use.
  static Device cpu(int threads = 0);
  /// The CUDA runtime's current GPU (CUDA_VISIBLE_DEVICES chooses); an error where this build has no CUDA or
  /// this machine no GPU.
  static Result<Device> cuda();
  /// Every device of this build and machine: the CPU first.
  static std::vector<Device> all();

  DeviceKind kind() const { return kind_; }
  int threads() const { return threads_; }
  /// "cpu, 2 threads" or the GPU's name.
  std::string name() const;
  /// The CPU's thread pool; checks that this is a CPU.
  tbb::detail::d1::task_arena& arena() const;
  /// Waits for everything launched here; errors of kernels are broken invariants and abort with the kernel's
  /// name.
  void synchronize() const;

 private:
  Device(DeviceKind kind, int threads, std::shared_ptr<tbb::detail::d1::task_arena> arena)
      : kind_(kind), threads_(threads), arena_(std::move(arena)) {}

  DeviceKind kind_;
  int threads_;
  std::shared_ptr<tbb::detail::d1::task_arena> arena_;
};

}  // namespace gvx::exec
