#include "gvx/core/noise.h"

#include <random>

#include <gtest/gtest.h>

namespace gvx {
namespace {

TEST(Noise, is_zero_at_lattice_points_and_continuous_across_cells) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-50, 50), apart(-1e-6, 1e-6);
  for (int i = 0; i < 20000; ++i) {
    Vec3d p(place(random), place(random), place(random));
    EXPECT_EQ(perlin({std::round(p.x), std::round(p.y), std::round(p.z)}, 3), 0);
    p.x = std::round(p.x);
    EXPECT_NEAR(perlin(p + Vec3d(apart(random), 0, 0), 3), perlin(p, 3), 1e-5);
  }
}

TEST(Noise, has_no_mean_and_fills_its_range) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-1000, 1000);
  double sum = 0, squares = 0, most = 0;
  constexpr int kCount = 200000;
  for (int i = 0; i < kCount; ++i) {
    const double v = perlin({place(random), place(random), place(random)}, 9);
    sum += v;
    squares += v * v;
    most = std::max(most, std::fabs(v));
  }
  EXPECT_NEAR(sum / kCount, 0, 0.004);
  EXPECT_NEAR(squares / kCount, 0.068, 0.01);
  EXPECT_GT(most, 0.85);
  EXPECT_LE(most, kPerlinMost);
}

TEST(Noise, bounds_hold_every_sample_and_close_in_on_small_boxes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-20, 20), share(0, 1);
  double widest_of_small = 0;
  for (int i = 0; i < 4000; ++i) {
    const double size = std::exp2(-8 * share(random) + 1.5);
    const Vec3d low(place(random), place(random), place(random));
    const Box3d box{low, low + size * Vec3d(share(random), share(random), share(random))};
    const noise::Interval bounds = perlin_bounds(box, 5);
    for (int k = 0; k < 250; ++k) {
      const Vec3d p =
          box.minimum + Vec3d(share(random), share(random), share(random)) * (box.maximum - box.minimum);
      const double v = perlin(p, 5);
      ASSERT_LE(bounds.low, v);
      ASSERT_GE(bounds.high, v);
    }
    if (size < 0.02) widest_of_small = std::max(widest_of_small, bounds.high - bounds.low);
  }
  EXPECT_LT(widest_of_small, 0.35);
}

TEST(Noise, octave_bounds_hold_at_every_footprint_up_to_the_coarsest) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0, 1);
  const FractalNoise fractal{.octaves = 9, .wavelength = 0.3, .seed = 7};
  for (int i = 0; i < 2000; ++i) {
    const double size = std::exp2(-9 * share(random)), coarsest = std::exp2(-10 * share(random));
    const Vec3d low(share(random), share(random), share(random));
    const Box3d box{low, low + Vec3d(size)};
    const noise::Interval bounds = fractal.bounds(box, coarsest);
    for (int k = 0; k < 200; ++k) {
      const Vec3d p = low + size * Vec3d(share(random), share(random), share(random));
      const double v = fractal(p, coarsest * std::exp2(-6 * share(random)));
      ASSERT_LE(bounds.low, v);
      ASSERT_GE(bounds.high, v);
    }
  }
}

TEST(Noise, rows_are_what_their_places_are) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> share(-1, 1);
  const FractalNoise fractal{.octaves = 7, .wavelength = 0.3, .seed = 7};
  for (int i = 0; i < 500; ++i) {
    const Vec3d first(share(random), share(random), share(random));
    const double step = std::exp2(6 * share(random) - 7), footprint = std::exp2(4 * share(random) - 8);
    double sums[20];
    fractal.row(first, step, 20, footprint, sums, [](const double*, double) { return false; });
    for (int k = 0; k < 20; ++k) {
      ASSERT_NEAR(sums[k], fractal(first + Vec3d(k * step, 0, 0), footprint), 1e-11);
    }
    // A row that is settled after some octaves is within the rest of what it would have been.
    double settled[20], rest = INFINITY;
    fractal.row(first, step, 20, footprint, settled, [&](const double*, double left) {
      rest = left;
      return left < 0.5;
    });
    for (int k = 0; k < 20; ++k) ASSERT_LE(std::fabs(settled[k] - sums[k]), std::max(rest, 0.0) + 1e-11);
  }
}

TEST(Noise, a_coarse_footprint_leaves_out_what_it_cannot_resolve) {
  const FractalNoise all{.octaves = 20, .wavelength = 0.5}, three{.octaves = 3, .wavelength = 0.5};
  const Vec3d p(0.31, 0.57, 0.83);
  // Waves of 1/2, 1/4, 1/8; the next would be 1/16: two voxels.
  EXPECT_EQ(all(p, 1.0 / 32), three(p, 1.0 / 32));
  EXPECT_EQ(all(p, 1), 0);
}

}  // namespace
}  // namespace gvx
