#include "gvx/surface/sampled_cells.h"

#include <random>

#include <gtest/gtest.h>

#include "gvx/surface/surface_brick.h"

namespace gvx::surface {
namespace {

Vec3f random_unit(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return normalize(Vec3f(normal(random), normal(random), normal(random)));
}

TEST(SampleAttributes, keep_normals_and_colours) {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    const Vec3f n = random_unit(random), c(0.1f, float(random() % 256) / 255, 1.2f);
    const SampleAttributes packed = pack(n, c);
    EXPECT_GT(dot(normal_of(packed), n), 1 - 1e-6f);
    EXPECT_NEAR(color_of(packed).y, c.y, 0.002f);
    EXPECT_EQ(color_of(packed).z, 1);
  }
  for (const Vec3f n : {Vec3f(0, 0, -1), Vec3f(-1, 0, 0), Vec3f(0, -1, 0)}) {
    EXPECT_GT(dot(normal_of(pack(n, {})), n), 1 - 1e-6f);
  }
}

TEST(SampledCells, coarser_ones_hold_finer_ones) {
  std::mt19937 random(2);
  SampledCells coarse;
  for (int octant = 0; octant < 8; ++octant) {
    SampledCells fine;
    for (int i = 0; i < 300; ++i) {
      fine.add(Cell(int(random() % 32), int(random() % 32), int(random() % 32)), {0, 0, 1}, Vec3f(0.5f));
    }
    coarse.add_finer(fine, octant);
    for (int z = 0; z < kCells; ++z) {
      for (int y = 0; y < kCells; ++y) {
        for (int x = 0; x < kCells; ++x) {
          if (!fine.cells().has({x, y, z})) continue;
          const Cell above((x + 32 * (octant & 1)) / 2, (y + 32 * (octant >> 1 & 1)) / 2,
                           (z + 32 * (octant >> 2)) / 2);
          ASSERT_TRUE(coarse.cells().has(above));
        }
      }
    }
  }
  EXPECT_LE(coarse.cells().count(), 8 * 300);
  EXPECT_EQ(coarse.primary_axis(), 2);
}

TEST(SampledCells, sheets_keep_one_of_their_sides) {
  SampledCells samples;
  for (int i = 0; i < 3; ++i) samples.add({1, 2, 3}, {0, 1, 0}, Vec3f(1, 0, 0));
  for (int i = 0; i < 2; ++i) samples.add({1, 2, 3}, {0, -1, 0}, Vec3f(0, 0, 0));
  const SampleAttributes shown = samples.attributes({1, 2, 3});
  EXPECT_GT(normal_of(shown).y, 0.999f);
  EXPECT_EQ(color_of(shown).x, 1);
}

TEST(SurfaceBrick, has_every_samples_attributes_by_rank_and_the_depths_of_blocks) {
  std::mt19937 random(3);
  SampledCells samples;
  for (int i = 0; i < 2000; ++i) {
    samples.add(Cell(int(random() % 32), int(random() % 32), int(random() % 9)), random_unit(random),
                Vec3f(0.5f));
  }
  const SurfaceBrick brick = make_brick(samples);
  const SurfaceBrickView view = brick.view();
  const GridAxes axes(brick.axis);
  for (int v = 0; v < kCells; ++v) {
    for (int u = 0; u < kCells; ++u) {
      for (int w = 0; w < kCells; ++w) {
        const Cell cell = axes.from_grid(Cell(u, v, w));
        const bool there = (view.grid.column(u, v) >> w & 1) != 0;
        ASSERT_EQ(there, samples.cells().has(cell));
        if (!there) continue;
        ASSERT_TRUE(view.block(u, v).meets(w, w));
        ASSERT_EQ(view.attributes[view.grid.rank(u, v, w)], samples.attributes(cell));
      }
    }
  }
}

}  // namespace
}  // namespace gvx::surface
