#include "gvx/exec/cuda_support.h"

#include <cstdio>

#if defined(__CUDACC__)
#include <cuda_runtime.h>
#endif

namespace gvx::exec::cuda_support {

#if defined(__CUDACC__)

namespace {

void require(cudaError_t status, const char* what) {
  if (status == cudaSuccess) return;
  std::fprintf(stderr, "gvx: CUDA: %s: %s\n", what, cudaGetErrorString(status));
  std::abort();
}

}  // namespace

Result<int> device_count() {
  int count = 0;
  const cudaError_t status = cudaGetDeviceCount(&count);
  if (status != cudaSuccess) return Error{std::string("no CUDA device: ") + cudaGetErrorString(status)};
  return count;
}

std::string device_name() {
  cudaDeviceProp properties;
  require(cudaGetDeviceProperties(&properties, 0), "cudaGetDeviceProperties");
  return properties.name;
}

void* allocate_shared(std::size_t bytes) {
  void* memory = nullptr;
  require(cudaMallocManaged(&memory, bytes), "cudaMallocManaged");
  require(cudaMemset(memory, 0, bytes), "cudaMemset");
  return memory;
}

void free_shared(void* memory) {
  cudaFree(memory);
}

void copy(void* to, const void* from, std::size_t bytes) {
  require(cudaMemcpy(to, from, bytes, cudaMemcpyDefault), "cudaMemcpy");
}

void synchronize(const char* what) {
  require(cudaDeviceSynchronize(), what);
}

#else

Result<int> device_count() {
  return Error{"no CUDA device: this gvx was built without CUDA"};
}
std::string device_name() {
  return "no CUDA";
}
void* allocate_shared(std::size_t) {
  check_failed("a CUDA buffer needs a build with CUDA", __FILE__, __LINE__);
}
void free_shared(void*) {}
void copy(void*, const void*, std::size_t) {}
void synchronize(const char*) {}

#endif

}  // namespace gvx::exec::cuda_support
