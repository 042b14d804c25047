#include "gvx/surface/cast.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace gvx::surface {
namespace {

SampledCells random_cells(std::mt19937& random, int count) {
  SampledCells samples;
  for (int i = 0; i < count; ++i) {
    samples.add(Cell(int(random() % 32), int(random() % 32), int(random() % 32)), {0, 0, 1}, Vec3f(0.5f));
  }
  return samples;
}

/// The distances between which a ray is in a cell; empty where it misses it.
RayInterval in_cell(const Ray& ray, Cell c) {
  const Vec3d low{Vec3<int>(c)};
  return intersect(ray, {low, low + Vec3d(1)}, 0, 1e300);
}

TEST(Cast, finds_the_first_cell_that_the_ray_comes_through) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-10, 42), inside(0, 32);
  int hits = 0, misses = 0;
  for (const int count : {5, 60, 3000}) {
    const SampledCells samples = random_cells(random, count);
    const SurfaceBrick brick = make_brick(samples);
    for (int trial = 0; trial < 2000; ++trial) {
      const Vec3d from(anywhere(random), anywhere(random), anywhere(random));
      Ray ray{from, Vec3d(inside(random), inside(random), inside(random)) - from};
      if (trial % 10 == 0) ray.direction[int(random() % 3)] = 0;
      if (trial % 50 == 0) ray.direction = Vec3d(0, 0, trial % 100 == 0 ? 1 : -1);
      double first = INFINITY;
      for (int z = 0; z < kCells; ++z) {
        for (int y = 0; y < kCells; ++y) {
          for (int x = 0; x < kCells; ++x) {
            if (!samples.cells().has({x, y, z})) continue;
            const RayInterval there = in_cell(ray, {x, y, z});
            if (there.exit - there.enter > 1e-9) first = std::min(first, there.enter);
          }
        }
      }
      const CastHit hit = cast(brick.view(), ray, {0, 1e300});
      ASSERT_EQ(hit.hit, first < INFINITY) << trial;
      (hit.hit ? hits : misses) += 1;
      if (!hit.hit) continue;
      ASSERT_TRUE(samples.cells().has(hit.cell));
      ASSERT_NEAR(hit.enter, first, 1e-9 * (1 + first));
      const RayInterval there = in_cell(ray, hit.cell);
      ASSERT_NEAR(hit.exit, there.exit, 1e-9 * (1 + there.exit));
    }
  }
  EXPECT_GT(hits, 1000);
  EXPECT_GT(misses, 1000);
}

TEST(Cast, ends_where_it_is_told_to) {
  SampledCells samples;
  samples.add({10, 10, 10}, {0, 0, 1}, {});
  const SurfaceBrick brick = make_brick(samples);
  const Ray ray{{10.5, 10.5, -5}, {0, 0, 1}};
  EXPECT_TRUE(cast(brick.view(), ray, {0, 100}).hit);
  EXPECT_FALSE(cast(brick.view(), ray, {0, 14.9}).hit);
  EXPECT_FALSE(cast(brick.view(), ray, {16.1, 100}).hit);
  EXPECT_NEAR(cast(brick.view(), ray, {15.25, 100}).enter, 15.25, 1e-12);
  EXPECT_FALSE(cast(make_brick(SampledCells()).view(), ray, {0, 100}).hit);
}

}  // namespace
}  // namespace gvx::surface
