#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/brick/brick_pool.h"

namespace gvx::brick {
namespace {

TEST(BrickPool, keeps_bricks_and_their_planes_apart) {
  constexpr std::size_t kTexels = BrickLayout<8>::kTexels;
  const VoxelFormat format{VoxelType::u16, VoxelContent::scalar, 2};
  BrickPool pool(exec::Device::cpu(), brick_bytes(format, 8), 3);
  std::vector<std::byte> bytes(pool.brick_bytes());
  for (std::uint32_t slot = 0; slot < 3; ++slot) {
    std::fill(bytes.begin(), bytes.end(), std::byte(slot));
    auto* voxels = reinterpret_cast<std::uint16_t*>(bytes.data());
    std::fill(voxels, voxels + kTexels, static_cast<std::uint16_t>(100 + slot));
    std::fill(voxels + kTexels, voxels + 2 * kTexels, static_cast<std::uint16_t>(200 + slot));
    pool.write(BrickIndex(slot), bytes);
  }
  const BrickPoolView<std::uint16_t, 8> view{pool.bytes(), pool.brick_bytes(), format.planes};
  for (std::uint32_t slot = 0; slot < 3; ++slot) {
    const auto brick = view.brick(BrickIndex(slot));
    EXPECT_EQ(brick.plane(0)[0], 100 + slot);
    EXPECT_EQ(brick.plane(0)[kTexels - 1], 100 + slot);
    EXPECT_EQ(brick.plane(1)[kTexels - 1], 200 + slot);
    EXPECT_EQ(brick.deviations(0)[0], slot);
    EXPECT_EQ(brick.deviations(1) + deviation_bytes(8),
              reinterpret_cast<const std::uint8_t*>(brick.voxels) + pool.brick_bytes());
  }
}

}  // namespace
}  // namespace gvx::brick
