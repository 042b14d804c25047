/// \file
/// Loads and stores that many threads may do at once on one word: relaxed, so never torn and never ordered.
/// Usage stamps and request marks need no more (GPU Pro text, 3.6.2): all writers write the same value, or
/// any will do.
#pragma once

#include <cstdint>

#include "gvx/core/macros.h"

namespace gvx::exec {

GVX_HD inline std::uint32_t load_relaxed(const std::uint32_t* word) {
#if defined(__CUDA_ARCH__)
  return *static_cast<const volatile std::uint32_t*>(word);
#else
  return __atomic_load_n(word, __ATOMIC_RELAXED);
#endif
}

GVX_HD inline void store_relaxed(std::uint32_t* word, std::uint32_t value) {
#if defined(__CUDA_ARCH__)
  *static_cast<volatile std::uint32_t*>(word) = value;
#else
  __atomic_store_n(word, value, __ATOMIC_RELAXED);
#endif
}

/// Adds to a counter that is read only after the kernel has ended.
GVX_HD inline void add_relaxed(unsigned long long* counter, unsigned long long value) {
#if defined(__CUDA_ARCH__)
  atomicAdd(counter, value);
#else
  __atomic_fetch_add(counter, value, __ATOMIC_RELAXED);
#endif
}

}  // namespace gvx::exec
