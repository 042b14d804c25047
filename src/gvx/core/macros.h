/// \file
/// The two macros that all code shares: GVX_HD marks what kernels may call, GVX_CHECK states an invariant.
#pragma once

#include <cstdio>
#include <cstdlib>

/// A function that runs on the host and, where the file is compiled as CUDA, on the device.
#if defined(__CUDACC__)
#define GVX_HD __host__ __device__
#else
#define GVX_HD
#endif

namespace gvx {

/// Prints the broken invariant and aborts: it is a bug of the program, never of its input.
[[noreturn]] inline void check_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "gvx: internal error: '%s' does not hold at %s:%d\n", condition, file, line);
  std::abort();
}

}  // namespace gvx

/// Host code only; stays on in release builds.
#define GVX_CHECK(condition) ((condition) ? void(0) : ::gvx::check_failed(#condition, __FILE__, __LINE__))
