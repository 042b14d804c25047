/// \file
/// Meshes of which everything is known, for tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/io/mesh.h"
#include "gvx/produce/mesh_spool.h"

namespace gvx::produce {

/// An icosahedron's triangles, each cut into four `cuts` times, its vertices on a sphere.
inline io::TriangleMesh sphere_mesh(Vec3d centre, double radius, int cuts) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3d> places = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                               {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::uint32_t, 3>> triangles = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int cut = 0; cut < cuts; ++cut) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(places.size()));
      if (is_new) places.push_back(0.5 * (normalize(places[a]) + normalize(places[b])));
      return found->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& t : triangles) {
      const std::uint32_t a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      for (const auto& part :
           {std::array{t[0], a, c}, std::array{a, t[1], b}, std::array{c, b, t[2]}, std::array{a, b, c}}) {
        finer.push_back(part);
      }
    }
    triangles = std::move(finer);
  }
  io::TriangleMesh mesh;
  for (const Vec3d& p : places) mesh.vertices.emplace_back(centre + radius * normalize(p));
  mesh.triangles = std::move(triangles);
  return mesh;
}

/// The mesh as if read from a file; colours, where there are, are those of the vertices.
inline std::unique_ptr<MeshSpool> spooled(const io::TriangleMesh& mesh) {
  auto spool = MeshSpool::create(testing::TempDir(), 1 << 20).value();
  GVX_CHECK(spool->add_vertices(mesh.vertices, mesh.colors).ok());
  GVX_CHECK(spool->add_triangles(mesh.triangles).ok() && spool->finish().ok());
  return spool;
}

}  // namespace gvx::produce
