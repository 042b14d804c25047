#include "gvx/brick/brick_pool.h"

namespace gvx::brick {

BrickPool::BrickPool(const exec::Device& device, std::size_t brick_bytes, std::uint32_t slots)
    : brick_bytes_(brick_bytes),
      bytes_(device, brick_bytes * slots),
      usage_(device, slots),
      cell_masks_(device, slots) {}

void BrickPool::write(BrickIndex index, std::span<const std::byte> voxels) {
  GVX_CHECK(voxels.size() == brick_bytes_ && index.value < slots());
  bytes_.write(index.value * brick_bytes_, voxels);
  cell_masks_.forget(index);
}

}  // namespace gvx::brick
