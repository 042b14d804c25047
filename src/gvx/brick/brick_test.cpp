#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/brick/brick_pool.h"
#include "gvx/brick/sample.h"

namespace gvx::brick {
namespace {

/// Linear in each coordinate, so trilinear sampling reproduces it.
float field(Vec3f p) {
  return 3 + 2 * p.x - p.y + 0.5f * p.z + 0.25f * p.x * p.y - 0.125f * p.y * p.z;
}

template <int M>
std::vector<float> field_brick() {
  std::vector<float> texels(BrickLayout<M>::kTexels);
  for (int z = 0; z < M + 2; ++z) {
    for (int y = 0; y < M + 2; ++y) {
      for (int x = 0; x < M + 2; ++x) {
        texels[BrickLayout<M>::offset(x, y, z)] = field({float(x) - 0.5f, float(y) - 0.5f, float(z) - 0.5f});
      }
    }
  }
  return texels;
}

template <typename T>
class Sample : public testing::Test {};
using BrickSizes = testing::Types<std::integral_constant<int, 8>, std::integral_constant<int, 16>,
                                  std::integral_constant<int, 32>>;
TYPED_TEST_SUITE(Sample, BrickSizes);

TYPED_TEST(Sample, reproduces_a_trilinear_field_and_its_gradient_up_to_the_faces) {
  constexpr int M = TypeParam::value;
  const auto texels = field_brick<M>();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> inside(0, M);
  for (int i = 0; i < 1000; ++i) {
    Vec3f p{inside(random), inside(random), inside(random)};
    if (i % 3 == 0) p[i / 3 % 3] = i % 2 == 0 ? 0.0f : float(M);
    const float tolerance = 1e-5f * (10 + M * M);
    ASSERT_NEAR(sample<M>(texels.data(), p), field(p), tolerance);
    const Vec3f g = gradient<M>(texels.data(), p);
    ASSERT_NEAR(g.x, 2 + 0.25f * p.y, tolerance);
    ASSERT_NEAR(g.y, -1 + 0.25f * p.x - 0.125f * p.z, tolerance);
    ASSERT_NEAR(g.z, 0.5f - 0.125f * p.y, tolerance);
  }
}

TYPED_TEST(Sample, stays_inside_the_brick_whatever_the_position) {
  constexpr int M = TypeParam::value;
  std::vector<std::uint8_t> texels(BrickLayout<M>::kTexels, 7);
  for (const float x : {-1e30f, -1.0f, -0.5f, float(M) + 0.5f, float(M) + 1.0f, 1e30f, NAN}) {
    const float v = sample<M>(texels.data(), {x, 0.0f, float(M)});
    EXPECT_TRUE(v == 7.0f) << x << " gives " << v;
  }
}

TEST(BrickPool, keeps_bricks_apart) {
  BrickPool pool(exec::Device::cpu(), BrickLayout<8>::kTexels * 2, 3);
  std::vector<std::uint16_t> voxels(BrickLayout<8>::kTexels);
  for (std::uint32_t slot = 0; slot < 3; ++slot) {
    std::fill(voxels.begin(), voxels.end(), static_cast<std::uint16_t>(100 + slot));
    pool.write(BrickIndex(slot), std::as_bytes(std::span(voxels)));
  }
  const auto view = pool.view<std::uint16_t, 8>();
  for (std::uint32_t slot = 0; slot < 3; ++slot) {
    EXPECT_EQ(view.brick(BrickIndex(slot))[0], 100 + slot);
    EXPECT_EQ(view.brick(BrickIndex(slot))[BrickLayout<8>::kTexels - 1], 100 + slot);
  }
}

}  // namespace
}  // namespace gvx::brick
