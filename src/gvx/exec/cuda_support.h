/// \file
/// What exec needs of the CUDA runtime. Built in every configuration: without CUDA each function says that
/// there is none, so that no other file asks how the build was configured.
#pragma once

#include <cstddef>
#include <string>

#include "gvx/core/result.h"

namespace gvx::exec::cuda_support {

/// The number of GPUs, or why there is none.
Result<int> device_count();
std::string device_name();
/// Memory that host and GPU both read and write, filled with zeros; checks for success, as the sizes come
/// from our own pools.
void* allocate_shared(std::size_t bytes);
void free_shared(void* memory);
/// From the host's memory or the GPU's to either; what is on the GPU does not leave it.
void copy(void* to, const void* from, std::size_t bytes);
/// Waits for all kernels; aborts with `what` where one failed.
void synchronize(const char* what);

}  // namespace gvx::exec::cuda_support
