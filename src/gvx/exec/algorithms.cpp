#include "gvx/exec/algorithms.h"

#include <tbb/task_arena.h>
#include <thrust/copy.h>
#include <thrust/execution_policy.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/partition.h>
#include <thrust/reduce.h>
#include <thrust/scan.h>
#include <thrust/system/tbb/execution_policy.h>

namespace gvx::exec {
namespace {

// Below this TBB's start-up costs more than two threads gain.
constexpr std::size_t kSerialBelow = 1 << 15;

struct IsZero {
  GVX_HD bool operator()(std::uint32_t word) const { return word == 0; }
};
struct IsNonzero {
  GVX_HD bool operator()(std::uint32_t word) const { return word != 0; }
};

/// Calls function(policy) with the execution policy that fits device and size.
template <typename Function>
auto with_policy([[maybe_unused]] const Device& device, [[maybe_unused]] std::size_t size,
                 Function function) {
#if defined(__CUDACC__)
  if (device.kind() == DeviceKind::cuda) return function(thrust::cuda::par);
#endif
#if defined(__SANITIZE_THREAD__)
  return function(thrust::seq);  // see parallel.h
#else
  if (size < kSerialBelow || device.threads() == 1) return function(thrust::seq);
  return device.arena().execute([&] { return function(thrust::tbb::par); });
#endif
}

}  // namespace

std::uint64_t exclusive_scan(const Device& device, BufferView<const std::uint32_t> input,
                             BufferView<std::uint32_t> output) {
  if (input.size == 0) return 0;
  return with_policy(device, input.size, [&](auto policy) {
    const auto sum = thrust::reduce(policy, input.begin(), input.end(), std::uint64_t(0));
    thrust::exclusive_scan(policy, input.begin(), input.end(), output.begin(), std::uint32_t(0));
    return sum;
  });
}

std::size_t stable_partition(const Device& device, BufferView<std::uint32_t> items,
                             BufferView<const std::uint32_t> flags, BufferView<std::uint32_t> scratch) {
  if (items.size == 0) return 0;
  return with_policy(device, items.size, [&](auto policy) {
    thrust::copy(policy, items.begin(), items.end(), scratch.begin());
    const auto middle = thrust::copy_if(policy, scratch.begin(), scratch.begin() + items.size, flags.begin(),
                                        items.begin(), IsZero{});
    thrust::copy_if(policy, scratch.begin(), scratch.begin() + items.size, flags.begin(), middle,
                    IsNonzero{});
    return static_cast<std::size_t>(middle - items.begin());
  });
}

std::size_t find_nonzero(const Device& device, BufferView<const std::uint32_t> words,
                         BufferView<std::uint32_t> indices) {
  if (words.size == 0) return 0;
  return with_policy(device, words.size, [&](auto policy) {
    const thrust::counting_iterator<std::uint32_t> first(0);
    const auto end = thrust::copy_if(policy, first, first + static_cast<std::ptrdiff_t>(words.size),
                                     words.begin(), indices.begin(), IsNonzero{});
    return static_cast<std::size_t>(end - indices.begin());
  });
}

}  // namespace gvx::exec
