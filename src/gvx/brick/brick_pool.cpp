#include "gvx/brick/brick_pool.h"

namespace gvx::brick {

namespace {

/// Vectors read up to so many bytes beyond a brick's last texel.
constexpr std::size_t kRoomBehind = 16;

}  // namespace

BrickPool::BrickPool(const exec::Device& device, std::size_t brick_bytes, std::uint32_t slots)
    : brick_bytes_(brick_bytes), slots_(slots), bytes_(device, brick_bytes * slots + kRoomBehind) {}

void BrickPool::release(std::span<const std::uint32_t> slots,
                        const std::function<bool(std::uint32_t)>& empty) {
  for (const std::uint32_t slot : slots) {
    // With its neighbours, as far as those are empty too: a page may hold parts of several.
    std::uint32_t first = slot, last = slot + 1;
    const auto most = static_cast<std::uint32_t>(exec::HostMemory::kPage / brick_bytes_ + 1);
    while (first > 0 && slot - first < most && empty(first - 1)) --first;
    while (last < slots_ && last - slot <= most && empty(last)) ++last;
    bytes_.release(first * brick_bytes_, (last - first) * brick_bytes_);
  }
}

void BrickPool::write(BrickIndex index, std::span<const std::byte> voxels) {
  GVX_CHECK(voxels.size() == brick_bytes_ && index.value < slots());
  bytes_.write(index.value * brick_bytes_, voxels);
}

}  // namespace gvx::brick
