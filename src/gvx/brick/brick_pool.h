/// \file
/// BrickPool owns the memory of all resident bricks: slots of equal size, one after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "gvx/brick/brick_layout.h"
#include "gvx/cache/usage_list.h"
#include "gvx/core/index.h"
#include "gvx/exec/buffer.h"
#include "gvx/exec/device.h"

namespace gvx::brick {

/// What kernels sample; Voxel is the pool's voxel type.
template <typename Voxel, int M>
struct BrickPoolView {
  const Voxel* voxels = nullptr;

  GVX_HD const Voxel* brick(BrickIndex index) const {
    return voxels + std::size_t(index.value) * BrickLayout<M>::kTexels;
  }
};

class BrickPool {
 public:
  /// `slots` bricks of `brick_bytes` each.
  BrickPool(const exec::Device& device, std::size_t brick_bytes, std::uint32_t slots);

  template <typename Voxel, int M>
  BrickPoolView<Voxel, M> view() const {
    GVX_CHECK(brick_bytes_ == BrickLayout<M>::kTexels * sizeof(Voxel));
    return {reinterpret_cast<const Voxel*>(bytes_.view().data)};
  }
  cache::UsageList& usage() { return usage_; }
  const cache::UsageList& usage() const { return usage_; }
  /// All slots, as bytes.
  const void* voxels() const { return bytes_.view().data; }
  std::uint32_t slots() const { return usage_.slots(); }
  std::size_t brick_bytes() const { return brick_bytes_; }

  /// Overwrites a slot with `brick_bytes()` bytes.
  void write(BrickIndex index, std::span<const std::byte> voxels);

 private:
  std::size_t brick_bytes_;
  exec::Buffer<std::byte> bytes_;
  cache::UsageList usage_;
};

}  // namespace gvx::brick
