#include "gvx/render/reference/sample.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace gvx::render::one_lane {
namespace {

/// Linear in each coordinate, so trilinear sampling reproduces it.
float field(Vec3f p) {
  return 3 + 2 * p.x - p.y + 0.5f * p.z + 0.25f * p.x * p.y - 0.125f * p.y * p.z;
}

template <int M>
std::vector<float> field_brick() {
  std::vector<float> texels(brick::BrickLayout<M>::kTexels);
  for (int z = -1; z < M + 3; ++z) {
    for (int y = -1; y < M + 3; ++y) {
      for (int x = -1; x < M + 3; ++x) {
        texels[brick::BrickLayout<M>::offset(x, y, z)] =
            field({float(x) - 0.5f, float(y) - 0.5f, float(z) - 0.5f});
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
    ASSERT_NEAR(sample(PlainTexels(texels.data(), M), M, p), field(p), tolerance);
    const Vec3f g = gradient(PlainTexels(texels.data(), M), M, p);
    ASSERT_NEAR(g.x, 2 + 0.25f * p.y, tolerance);
    ASSERT_NEAR(g.y, -1 + 0.25f * p.x - 0.125f * p.z, tolerance);
    ASSERT_NEAR(g.z, 0.5f - 0.125f * p.y, tolerance);
  }
}

TYPED_TEST(Sample, stays_inside_the_brick_whatever_the_position) {
  constexpr int M = TypeParam::value;
  std::vector<std::uint8_t> texels(brick::BrickLayout<M>::kTexels, 7);
  for (const float x : {-1e30f, -1.0f, -0.5f, float(M) + 0.5f, float(M) + 1.0f, 1e30f, NAN}) {
    const float v = sample(PlainTexels(texels.data(), M), M, {x, 0.0f, float(M)});
    EXPECT_TRUE(v == 7.0f) << x << " gives " << v;
  }
}

TEST(SampleOfOnePlane, deviations_are_units_times_what_codes_mean_and_continuous) {
  std::vector<std::uint8_t> bytes(deviation_bytes(8));
  const float unit = 0.5f;
  std::memcpy(bytes.data(), &unit, sizeof(unit));
  for (std::size_t i = sizeof(unit); i < bytes.size(); ++i) bytes[i] = i % 6 < 3 ? 10 : 0x45;
  EXPECT_EQ(deviation(bytes.data(), 8, {1, 1, 1}),
            0.5f * (bytes[4 + 1 + 6 * (1 + 6)] == 10 ? 26.0f / 16 : 21.0f));
  float before = deviation(bytes.data(), 8, {0, 3, 3});
  for (float x = 0; x <= 8; x += 0.01f) {
    const float now = deviation(bytes.data(), 8, {x, 3, 3});
    ASSERT_NEAR(now, before, 0.1);
    before = now;
  }
  std::fill(bytes.begin(), bytes.end(), std::uint8_t(0));
  EXPECT_EQ(deviation(bytes.data(), 8, {1, 1, 1}), 0.0f);
}

TEST(SampleOfOnePlane, nearest_is_the_texel_that_the_position_is_in) {
  const auto nearest = [](Vec3f p) { return static_cast<int>(corner_texel(8)) + nearest_texel(p, 8); };
  const auto offset = brick::BrickLayout<8>::offset;
  for (const float x : {0.0f, 0.3f, 0.99f, 1.0f, 7.99f}) {
    EXPECT_EQ(nearest({x, 2.5f, 0}), offset(1 + static_cast<int>(x), 3, 1));
  }
  EXPECT_EQ(nearest({-1, 8, 1e30f}), offset(1, 8, 8));
}

}  // namespace
}  // namespace gvx::render::one_lane
