#include "gvx/mesh/surface_builder.h"

#include <map>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/mesh/mesh_test_support.h"
#include "gvx/surface/surface_brick.h"

namespace gvx::mesh {
namespace {

using surface::Cell;
using surface::kCells;

/// All bricks of a surface, by level and place.
struct Built {
  SurfaceSpace space;
  std::map<std::tuple<std::uint32_t, std::uint64_t, std::uint64_t, std::uint64_t>, surface::SampledCells>
      bricks;

  /// Cell (x, y, z) of the whole finest level.
  bool has(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const auto at = [](std::int64_t v) { return static_cast<std::uint64_t>(v / kCells); };
    const auto brick = bricks.find({space.finest_level, at(x), at(y), at(z)});
    return brick != bricks.end() &&
           brick->second.cells().has({int(x % kCells), int(y % kCells), int(z % kCells)});
  }
  std::int64_t across() const { return std::int64_t{kCells} << space.finest_level; }
};

Built build(const io::TriangleMesh& mesh, double cell, std::uint64_t memory = 64 << 20) {
  const auto spool = spooled(mesh);
  Built built;
  built.space = surface_space(spool->summary(), cell);
  const Status done =
      build_surface(*spool, built.space, memory, [&](const surface::SurfacePyramid::Made& made) -> Status {
        const NodeKey& k = made.key;
        EXPECT_TRUE(built.bricks.try_emplace({k.level, k.x, k.y, k.z}, made.samples).second);
        return {};
      });
  EXPECT_TRUE(done.ok()) << done.error().message;
  return built;
}

TEST(SurfaceBuilder, cells_follow_the_triangles) {
  // An icosahedron's edges on a sphere of radius 1 are 1.05 long, an eighth of that after three cuts.
  const double cell = cell_of(*spooled(sphere_mesh({}, 1, 3))).value();
  EXPECT_GT(cell, 0.7 * 0.12);
  EXPECT_LT(cell, 0.7 * 0.16);
  const SurfaceSpace space = surface_space(spooled(sphere_mesh({5, 6, 7}, 1, 1))->summary(), 0.01);
  EXPECT_EQ(space.finest_level, 3u);
  EXPECT_EQ(space.cell, 0.01);
  const SurfaceSpace too_fine = surface_space(spooled(sphere_mesh({}, 1, 1))->summary(), 1e-9);
  EXPECT_EQ(too_fine.finest_level, kFinestSurface);
  EXPECT_GT(too_fine.cell, 1e-7);
}

TEST(SurfaceBuilder, a_closed_mesh_is_closed_across_all_its_bricks) {
  const Vec3d centre(0.3, -2, 11);
  const Built built = build(sphere_mesh(centre, 1, 4), 0.017);
  ASSERT_EQ(built.space.finest_level, 2u);
  const std::int64_t across = built.across();
  std::vector<bool> seen(static_cast<std::size_t>(across * across * across));
  const auto at = [&](Vec3i c) { return static_cast<std::size_t>(c.x + across * (c.y + across * c.z)); };
  std::vector<Vec3i> next{{0, 0, 0}};
  std::int64_t outside = 0, cells = 0;
  while (!next.empty()) {
    const Vec3i cell = next.back();
    next.pop_back();
    ++outside;
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::int64_t step : {-1, 1}) {
        Vec3i beside = cell;
        beside[axis] += step;
        if (beside[axis] < 0 || beside[axis] >= across || seen[at(beside)]) continue;
        if (built.has(beside.x, beside.y, beside.z)) continue;
        seen[at(beside)] = true;
        next.push_back(beside);
      }
    }
  }
  for (std::int64_t z = 0; z < across; ++z) {
    for (std::int64_t y = 0; y < across; ++y) {
      for (std::int64_t x = 0; x < across; ++x) cells += built.has(x, y, z) ? 1 : 0;
    }
  }
  const double radius = 1 / built.space.cell, inside = double(across * across * across - outside - cells);
  EXPECT_NEAR(inside, 4.0 / 3 * M_PI * std::pow(radius, 3), 0.06 * inside);
  EXPECT_GT(cells, 3 * M_PI * radius * radius);
}

TEST(SurfaceBuilder, what_is_made_does_not_depend_on_memory) {
  io::TriangleMesh mesh = sphere_mesh({}, 1, 3);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.colors.emplace_back(float(i % 7) / 7, 0.5f, 1.0f);
  const Built plenty = build(mesh, 0.02), little = build(mesh, 0.02, 20000);
  ASSERT_EQ(plenty.bricks.size(), little.bricks.size());
  for (const auto& [place, samples] : plenty.bricks) {
    const surface::SampledCells& other = little.bricks.at(place);
    ASSERT_EQ(samples.cells(), other.cells());
    const surface::SurfaceBrick a = surface::make_brick(samples), b = surface::make_brick(other);
    ASSERT_EQ(a.grid.bytes, b.grid.bytes);
    ASSERT_EQ(a.attributes, b.attributes);
  }
}

TEST(SurfaceBuilder, large_triangles_are_in_all_bricks_that_they_cross_and_in_few_others) {
  io::TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0.1f, 0.9f}, {0.05f, 1, 0.4f}, {1, 1, 1}};
  sheet.triangles = {{0, 1, 2}, {1, 3, 2}};
  const Built built = build(sheet, 1.0 / 250);
  ASSERT_EQ(built.space.finest_level, 3u);
  // Each line along z that meets the sheet finds one cell at least.
  std::int64_t met = 0;
  for (std::int64_t y = 0; y < built.across(); ++y) {
    for (std::int64_t x = 0; x < built.across(); ++x) {
      bool there = false;
      for (std::int64_t z = 0; z < built.across() && !there; ++z) there = built.has(x, y, z);
      met += there ? 1 : 0;
    }
  }
  const double area = 0.5 * std::fabs(1 * 1 - 0.1 * 0.05) + 0.5 * std::fabs(0.95 * 0.9);
  EXPECT_GT(double(met), area * 250 * 250 * 0.98);
  EXPECT_LT(double(met), area * 250 * 250 * 1.15);
}

TEST(SurfaceBuilder, a_single_triangle_is_a_surface) {
  io::TriangleMesh one;
  one.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  const Built built = build(one, 0.05);
  EXPECT_EQ(built.space.finest_level, 0u);
  ASSERT_EQ(built.bricks.size(), 1u);
  const surface::SampledCells& samples = built.bricks.begin()->second;
  EXPECT_NEAR(samples.cells().count(), 0.5 * 20 * 20, 25);
  EXPECT_EQ(samples.primary_axis(), 2);
}

}  // namespace
}  // namespace gvx::mesh
