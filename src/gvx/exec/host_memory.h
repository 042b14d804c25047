/// \file
/// HostMemory: zeroed memory of the host, in large pages where the system has them.
#pragma once

#include <cstddef>
#include <utility>

namespace gvx::exec {

/// Owns bytes at a multiple of kAlignment. Pages cost nothing until they are written. A renderer goes to and
/// fro in hundreds of megabytes, of which a processor keeps in mind but a few thousand pages.
class HostMemory {
 public:
  /// A cache line's: what is made of such pieces straddles none.
  static constexpr std::size_t kAlignment = 64;

  HostMemory() = default;
  /// Throws std::bad_alloc.
  explicit HostMemory(std::size_t bytes);
  HostMemory(HostMemory&& other) noexcept { swap(other); }
  HostMemory& operator=(HostMemory&& other) noexcept {
    HostMemory(std::move(other)).swap(*this);
    return *this;
  }
  ~HostMemory();

  void* data() const { return data_; }

 private:
  void swap(HostMemory& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
  }

  void *memory_ = nullptr, *data_ = nullptr;
};

}  // namespace gvx::exec
