/// \file
/// Buffer<T> owns an array that a device works on; BufferView<T> is what kernels take. On CUDA the memory is
/// managed: after Device::synchronize() the host reads and writes it through the same view.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "gvx/core/macros.h"
#include "gvx/exec/cuda_support.h"
#include "gvx/exec/device.h"
#include "gvx/exec/host_memory.h"

namespace gvx::exec {

/// A pointer and a length, trivially copyable into kernels. Indexing is unchecked.
template <typename T>
struct BufferView {
  T* data = nullptr;
  std::size_t size = 0;

  GVX_HD T& operator[](std::size_t i) const { return data[i]; }
  GVX_HD T* begin() const { return data; }
  GVX_HD T* end() const { return data + size; }
  GVX_HD operator BufferView<const T>() const requires(!std::is_const_v<T>) { return {data, size}; }
};

/// Owns `size` trivially copyable elements on a device, zeroed; moves, never copies.
template <typename T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  Buffer(const Device& device, std::size_t size) : kind_(device.kind()), size_(size) {
    if (size == 0) return;
    static_assert(alignof(T) <= HostMemory::kAlignment);
    if (size > SIZE_MAX / sizeof(T)) throw std::bad_alloc();
    const std::size_t bytes = size * sizeof(T);
    if (kind_ == DeviceKind::cuda) {
      data_ = static_cast<T*>(cuda_support::allocate_shared(bytes));
      if (data_ == nullptr) throw std::bad_alloc();
    } else {
      memory_ = HostMemory(bytes);
      data_ = static_cast<T*>(memory_.data());
    }
  }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    Buffer(std::move(other)).swap(*this);
    return *this;
  }
  ~Buffer() {
    if (kind_ == DeviceKind::cuda) cuda_support::free_shared(data_);
  }

  /// Writes elements from `first` on, out of the host's memory or a device's.
  void write(std::size_t first, std::span<const T> source) {
    if (source.empty()) return;
    if (kind_ == DeviceKind::cuda) {
      cuda_support::copy(data_ + first, source.data(), source.size_bytes());
    } else {
      std::memcpy(data_ + first, source.data(), source.size_bytes());
    }
  }

  /// Gives elements' memory back to the system, as far as that is whole pages: they are zero again. Of memory
  /// that a GPU works on nothing is given back.
  void release(std::size_t first, std::size_t count) {
    if (kind_ == DeviceKind::cpu) memory_.release(first * sizeof(T), count * sizeof(T));
  }

  std::size_t size() const { return size_; }
  BufferView<T> view() { return {data_, size_}; }
  BufferView<const T> view() const { return {data_, size_}; }

 private:
  void swap(Buffer& other) noexcept {
    std::swap(kind_, other.kind_);
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
  }

  DeviceKind kind_ = DeviceKind::cpu;
  HostMemory memory_;  // a CPU's
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace gvx::exec
