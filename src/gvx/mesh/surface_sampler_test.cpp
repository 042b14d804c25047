#include "gvx/mesh/surface_sampler.h"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace gvx::mesh {
namespace {

using surface::Cell;
using surface::kCells;

/// Of a place in cells.
Vec3<std::int32_t> parts_of(Vec3d place) {
  const auto whole = [](double v) { return static_cast<std::int32_t>(std::lround(v * double(kCellParts))); };
  return {whole(place.x), whole(place.y), whole(place.z)};
}

/// A closed surface around a place: an octahedron, split `times` times, whose corners lie at
/// radius(direction).
template <typename Radius>
std::vector<SurfaceTriangle> closed_surface(Vec3d centre, int times, Radius radius) {
  std::vector<std::array<Vec3d, 3>> faces;
  for (int octant = 0; octant < 8; ++octant) {
    const auto sign = [&](int bit) { return (octant >> bit & 1) != 0 ? -1.0 : 1.0; };
    faces.push_back({Vec3d(sign(0), 0, 0), Vec3d(0, sign(1), 0), Vec3d(0, 0, sign(2))});
  }
  for (int i = 0; i < times; ++i) {
    std::vector<std::array<Vec3d, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const Vec3d ab = normalize(a + b), bc = normalize(b + c), ca = normalize(c + a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  std::vector<SurfaceTriangle> triangles;
  for (const auto& face : faces) {
    SurfaceTriangle triangle;
    for (int i = 0; i < 3; ++i) {
      const Vec3d direction = face[static_cast<std::size_t>(i)];
      triangle.corner[i] = parts_of(centre + radius(direction) * direction);
      for (std::size_t k = 0; k < 3; ++k)
        triangle.normal[i][k] = static_cast<std::int16_t>(std::lround(32767 * direction[int(k)]));
      triangle.color[i] = {64, 128, 192};
    }
    triangles.push_back(triangle);
  }
  return triangles;
}

/// Which cells can be come to from the corner of the brick, from cell to adjacent cell, without those of the
/// surface.
std::vector<bool> outside_of(const surface::CellSet& cells) {
  std::vector<bool> seen(kCells * kCells * kCells);
  const auto at = [](Cell c) { return static_cast<std::size_t>(c.x + kCells * (c.y + kCells * c.z)); };
  std::vector<Cell> next{{0, 0, 0}};
  seen[0] = true;
  while (!next.empty()) {
    const Cell cell = next.back();
    next.pop_back();
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        Cell beside = cell;
        beside[axis] += step;
        if (beside[axis] < 0 || beside[axis] >= kCells || seen[at(beside)] || cells.has(beside)) continue;
        seen[at(beside)] = true;
        next.push_back(beside);
      }
    }
  }
  return seen;
}

TEST(SurfaceSampler, no_path_from_cell_to_adjacent_cell_leads_through_a_closed_surface) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 40; ++trial) {
    const Vec3d centre(15.5 + unit(random), 15.5 + unit(random), 15.5 + unit(random));
    const double bumps = 9 * unit(random), depth = 3 * unit(random);
    const auto radius = [&](Vec3d d) {
      return 9 + depth * std::sin(bumps * d.x) * std::cos(bumps * d.y + d.z);
    };
    SurfaceSampler sampler;
    // From a few large triangles to many slivers.
    for (const SurfaceTriangle& triangle : closed_surface(centre, trial % 6, radius)) sampler.add(triangle);
    const surface::CellSet& cells = sampler.samples().cells();
    ASSERT_FALSE(cells.has(Cell(0, 0, 0)));
    ASSERT_FALSE(outside_of(cells)[16 + kCells * (16 + kCells * 16)]) << "trial " << trial;
  }
}

TEST(SurfaceSampler, finds_cells_that_the_surface_is_in_and_no_others) {
  const Vec3d centre(16.3, 15.9, 16.1);
  SurfaceSampler sampler;
  for (const SurfaceTriangle& triangle : closed_surface(centre, 5, [](Vec3d) { return 11.0; }))
    sampler.add(triangle);
  int count = 0;
  for (int z = 0; z < kCells; ++z) {
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) {
        if (!sampler.samples().cells().has({x, y, z})) continue;
        ++count;
        const Vec3d middle = Vec3d(x + 0.5, y + 0.5, z + 0.5) - centre;
        EXPECT_NEAR(length(middle), 11, 0.5 * std::sqrt(3.0) + 0.05);
        const surface::SampleAttributes there = sampler.samples().attributes({x, y, z});
        EXPECT_GT(dot(surface::normal_of(there), Vec3f(normalize(middle))), 0.99f);
        EXPECT_NEAR(surface::color_of(there).y, 0.5f, 0.003f);
      }
    }
  }
  // About as many as lines cut it: the areas that are seen along the axes, 6 pi r^2, less the cells found
  // twice.
  EXPECT_GT(count, 3 * M_PI * 11 * 11);
  EXPECT_LT(count, 6 * M_PI * 11 * 11);
}

TEST(SurfaceSampler, bricks_side_by_side_lose_nothing_between_them) {
  // A sheet that lies in their common face, or nearly.
  for (const double off : {0.0, 1e-4, -1e-4, 0.3, -0.3}) {
    SurfaceSampler left, right;
    const Vec3d corners[] = {{32 + off, -3, -3}, {32 + off, 40, -2}, {32, 40, 41}, {32 - off, -2, 40}};
    for (const auto& [a, b, c] : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      SurfaceTriangle triangle{};
      for (const auto& [i, k] : {std::pair(0, a), std::pair(1, b), std::pair(2, c)}) {
        triangle.corner[i] = parts_of(corners[k]);
      }
      left.add(triangle);
      for (auto& corner : triangle.corner) corner.x -= kCells * int(kCellParts);
      right.add(triangle);
    }
    for (int z = 0; z < kCells; ++z) {
      for (int y = 0; y < kCells; ++y) {
        ASSERT_TRUE(left.samples().cells().has({kCells - 1, y, z}) || right.samples().cells().has({0, y, z}));
      }
    }
  }
}

TEST(SurfaceSampler, degenerate_triangles_are_nothing) {
  SurfaceSampler sampler;
  SurfaceTriangle point{}, line{};
  for (int i = 0; i < 3; ++i) {
    point.corner[i] = parts_of({4.5, 4.5, 4.5});
    line.corner[i] = parts_of({1.5 + 9 * i, 2.5 + 3 * i, 3.5});
  }
  sampler.add(point);
  sampler.add(line);
  EXPECT_TRUE(sampler.samples().cells().empty());
}

}  // namespace
}  // namespace gvx::mesh
