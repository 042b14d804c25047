/// \file
/// parallel_for: host loops on a CPU device's threads. The one place where oneTBB runs our code.
#pragma once

#include <cstddef>

#if defined(__SANITIZE_THREAD__)
#include <atomic>
#include <thread>
#include <vector>
#else
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

#include "gvx/exec/device.h"

namespace gvx::exec {

/// Calls function(i) for every i below `count`, in any order and from several threads, and waits. `cpu` is a
/// CPU.
template <typename Function>
void parallel_for(const Device& cpu, std::size_t count, const Function& function) {
#if defined(__SANITIZE_THREAD__)
  // The thread sanitizer cannot see how oneTBB, which was not built with it, orders its threads; it sees
  // these.
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) function(i);
  };
  std::vector<std::thread> threads;
  for (int t = 1; t < cpu.threads(); ++t) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
#else
  cpu.arena().execute([&] { tbb::parallel_for(std::size_t(0), count, function); });
#endif
}

}  // namespace gvx::exec
