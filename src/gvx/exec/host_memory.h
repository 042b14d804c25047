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

  /// The system's pages.
  static constexpr std::size_t kPage = 4096;
  /// Gives the whole pages within this part back to the system: they are zero again, and cost nothing until
  /// they are written.
  void release(std::size_t first_byte, std::size_t bytes);

 private:
  void swap(HostMemory& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(by_pages_, other.by_pages_);
  }

  void *memory_ = nullptr, *data_ = nullptr;
  bool by_pages_ = false;  // large enough to be pages of its own
};

}  // namespace gvx::exec
