/// \file
/// BrickPool owns the memory of all resident bricks: slots of equal size, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>

#include "gvx/brick/brick_layout.h"
#include "gvx/core/index.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"

namespace gvx::brick {

/// A brick as kernels see it (core/voxel.h draws its layout).
template <typename Voxel, int M>
struct BrickView {
  const Voxel* voxels = nullptr;
  std::uint32_t planes = 1;

  GVX_HD const Voxel* plane(std::uint32_t index) const { return voxels + index * BrickLayout<M>::kTexels; }
  /// The deviations of a plane, where the format has them.
  GVX_HD const std::uint8_t* deviations(std::uint32_t index) const {
    return reinterpret_cast<const std::uint8_t*>(plane(planes)) + index * deviation_bytes(M);
  }
};

/// What kernels find bricks in; Voxel is the pool's voxel type.
template <typename Voxel, int M>
struct BrickPoolView {
  const std::byte* bytes = nullptr;
  std::size_t brick_bytes = 0;
  std::uint32_t planes = 1;

  GVX_HD BrickView<Voxel, M> brick(BrickIndex index) const {
    return {reinterpret_cast<const Voxel*>(bytes + index.value * brick_bytes), planes};
  }
};

class BrickPool {
 public:
  /// `slots` bricks of `brick_bytes` each.
  BrickPool(const exec::Device& device, std::size_t brick_bytes, std::uint32_t slots);

  /// All slots, as bytes.
  const std::byte* bytes() const { return bytes_.view().data; }
  std::uint32_t slots() const { return slots_; }
  std::size_t brick_bytes() const { return brick_bytes_; }

  /// Gives the memory of these slots back to the system, as far as whole pages of it hold nothing else;
  /// `empty` says of each slot whether it may be lost. On a GPU nothing is given back.
  void release(std::span<const std::uint32_t> slots, const std::function<bool(std::uint32_t)>& empty);

  /// Overwrites a slot with `brick_bytes()` bytes, out of the host's memory or the device's.
  void write(BrickIndex index, std::span<const std::byte> voxels);

 private:
  std::size_t brick_bytes_;
  std::uint32_t slots_;
  exec::Buffer<std::byte> bytes_;
};

}  // namespace gvx::brick
