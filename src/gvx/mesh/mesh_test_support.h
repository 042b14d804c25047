/// \file
/// Meshes of which everything is known, for tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/io/mesh.h"
#include "gvx/mesh/mesh_spool.h"
#include "gvx/store/store_reader.h"

namespace gvx::mesh {

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

/// The finest voxels of a mesh's store.
class StoredMesh {
 public:
  using Voxel = std::array<std::uint8_t, 7>;

  explicit StoredMesh(const std::string& path) : reader_(store::StoreReader::open(path).value()) {
    const store::VolumeInfo& info = reader_->info();
    const Vec3i d = info.shape.dimensions;
    voxels_.resize(static_cast<std::size_t>(d.x * d.y * d.z));
    const std::int64_t m = info.shape.m;
    std::vector<std::byte> brick(info.brick_bytes());
    const std::size_t border = kBrickBorder, edge = static_cast<std::size_t>(m) + 2 * border,
                      texels = edge * edge * edge;
    const Vec3i nodes = info.shape.level_nodes(info.shape.levels - 1);
    for (std::int64_t n = 0; n < nodes.x * nodes.y * nodes.z; ++n) {
      const Vec3i node(n % nodes.x, n / nodes.x % nodes.y, n / nodes.x / nodes.y);
      const NodeKey key{info.shape.levels - 1, static_cast<std::uint32_t>(node.x),
                        static_cast<std::uint32_t>(node.y), static_cast<std::uint32_t>(node.z)};
      GVX_CHECK(reader_->read_brick(key, reader_->node(key).value(), brick).ok());
      for (std::int64_t i = 0; i < m * m * m; ++i) {
        const Vec3i in(i % m, i / m % m, i / m / m), at = m * node + in;
        if (at.x >= d.x || at.y >= d.y || at.z >= d.z) continue;
        const std::size_t texel = static_cast<std::size_t>(in.x) + border +
                                  edge * (static_cast<std::size_t>(in.y) + border +
                                          edge * (static_cast<std::size_t>(in.z) + border));
        for (std::size_t c = 0; c < 7; ++c) {
          voxels_[static_cast<std::size_t>((at.z * d.y + at.y) * d.x + at.x)][c] =
              static_cast<std::uint8_t>(brick[c * texels + texel]);
        }
      }
    }
  }

  const store::VolumeInfo& info() const { return reader_->info(); }
  const std::vector<Voxel>& voxels() const { return voxels_; }

  /// That which holds a place of the world; none where none does.
  Voxel at(Vec3d place) const {
    const Vec3d p = inverse(info().voxel_to_world).point(place);
    const Vec3i d = info().shape.dimensions, i(Vec3d(std::floor(p.x), std::floor(p.y), std::floor(p.z)));
    for (int axis = 0; axis < 3; ++axis) {
      if (i[axis] < 0 || i[axis] >= d[axis]) return {};
    }
    return voxels_[static_cast<std::size_t>((i.z * d.y + i.y) * d.x + i.x)];
  }
  double opacity(Vec3d place) const { return at(place)[3] / 255.0; }

  /// Of what is covered, in the world.
  double volume() const {
    double sum = 0;
    for (const Voxel& v : voxels_) sum += v[3] / 255.0;
    return sum * std::pow(info().voxel_to_world.column[0].x, 3);
  }
  /// Voxels of more than half an opacity.
  std::size_t opaque() const {
    return static_cast<std::size_t>(
        std::count_if(voxels_.begin(), voxels_.end(), [](const Voxel& v) { return v[3] > 127; }));
  }

 private:
  std::unique_ptr<store::StoreReader> reader_;
  std::vector<Voxel> voxels_;
};

/// The mesh as if read from a file; colours, where there are, are those of the vertices.
inline std::unique_ptr<MeshSpool> spooled(const io::TriangleMesh& mesh) {
  auto spool = MeshSpool::create(testing::TempDir(), 1 << 20).value();
  std::vector<Vec3d> places;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) places.push_back(mesh.place(v));
  GVX_CHECK(spool->add_vertices(places, mesh.colors).ok());
  GVX_CHECK(spool->add_triangles(mesh.triangles).ok() && spool->finish().ok());
  return spool;
}

}  // namespace gvx::mesh
