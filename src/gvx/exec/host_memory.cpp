#include "gvx/exec/host_memory.h"

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace gvx::exec {
namespace {

constexpr std::size_t kLargePage = 2 << 20;

}  // namespace

HostMemory::HostMemory(std::size_t bytes) {
  if (bytes == 0) return;
  const bool large = bytes >= kLargePage / 2;
  const std::size_t alignment = large ? kLargePage : kAlignment;
  if (bytes > SIZE_MAX / 2) throw std::bad_alloc();
  const std::size_t whole = (bytes + alignment - 1) / alignment * alignment;
  std::size_t room = whole + alignment;
  // Zeroed by the system, so that pages are left untouched until they are used.
  memory_ = std::calloc(1, room);
  if (memory_ == nullptr) throw std::bad_alloc();
  data_ = memory_;
  std::align(alignment, whole, data_, room);
#if defined(__linux__)
  // A wish: where it is not granted, all is as it was.
  if (large) madvise(data_, whole, MADV_HUGEPAGE);
  by_pages_ = large;
#endif
}

void HostMemory::release([[maybe_unused]] std::size_t first_byte, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  if (!by_pages_) return;
  const std::size_t first = (first_byte + kPage - 1) / kPage * kPage;
  const std::size_t last = (first_byte + bytes) / kPage * kPage;
  if (first < last) madvise(static_cast<char*>(data_) + first, last - first, MADV_DONTNEED);
#endif
}

HostMemory::~HostMemory() {
  std::free(memory_);
}

}  // namespace gvx::exec
