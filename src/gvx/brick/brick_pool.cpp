#include "gvx/brick/brick_pool.h"

namespace gvx::brick {

namespace {

/// Vectors read up to so many bytes beyond a brick's last texel.
constexpr std::size_t kRoomBehind = 16;

}  // namespace

BrickPool::BrickPool(const exec::Device& device, std::size_t brick_bytes, std::uint32_t slots)
    : brick_bytes_(brick_bytes), slots_(slots), bytes_(device, brick_bytes * slots + kRoomBehind) {}

void BrickPool::write(BrickIndex index, std::span<const std::byte> voxels) {
  GVX_CHECK(voxels.size() == brick_bytes_ && index.value < slots());
  bytes_.write(index.value * brick_bytes_, voxels);
}

}  // namespace gvx::brick
