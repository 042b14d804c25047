/// \file
/// Parallel algorithms on index lists, by Thrust: its TBB system on the CPU, its CUDA system on GPUs.
#pragma once

#include <cstdint>

#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"

namespace gvx::exec {

/// output[i] = sum of input[0..i-1]; returns the sum of all. The views may be the same.
std::uint64_t exclusive_scan(const Device& device, BufferView<const std::uint32_t> input,
                             BufferView<std::uint32_t> output);

/// Reorders `items` so that those whose flag is zero come first, keeping the order within both groups;
/// returns how many come first. flags[i] belongs to items[i] before the call and is left as it is. `scratch`
/// is of the same size.
std::size_t stable_partition(const Device& device, BufferView<std::uint32_t> items,
                             BufferView<const std::uint32_t> flags, BufferView<std::uint32_t> scratch);

/// Writes the indices i with words[i] != 0 to `indices`, in order; returns how many. `indices` is as long as
/// `words`.
std::size_t find_nonzero(const Device& device, BufferView<const std::uint32_t> words,
                         BufferView<std::uint32_t> indices);

}  // namespace gvx::exec
