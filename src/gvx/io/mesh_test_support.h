/// \file
/// Small mesh files, and what is read of them, for tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/io/mesh.h"

namespace gvx::io {

/// Writes a file of that text into the tests' folder; its path.
inline std::string written(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + "gvx_mesh_" + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

/// The bytes of the values, little-endian, one behind the other.
template <typename... Values>
std::string bytes_of(Values... values) {
  std::string bytes;
  (bytes.append(reinterpret_cast<const char*>(&values), sizeof(values)), ...);
  return bytes;
}

/// Keeps all that it is told.
class KeepingSink final : public MeshSink {
 public:
  Status add_vertices(std::span<const Vec3d> some, std::span<const Vec3f> colors) override {
    places.insert(places.end(), some.begin(), some.end());
    vertex_colors.insert(vertex_colors.end(), colors.begin(), colors.end());
    return {};
  }
  Status add_triangles(std::span<const Triangle> some, std::span<const Vec3f> colors) override {
    triangles.insert(triangles.end(), some.begin(), some.end());
    triangle_colors.insert(triangle_colors.end(), colors.begin(), colors.end());
    return {};
  }
  Result<Vec3d> place(std::uint32_t vertex) override {
    return vertex < places.size() ? places[vertex] : Vec3d(NAN);
  }
  void pass_over(const std::string& what) override { unused.insert(what); }

  Box3d bounds() const {
    Box3d box{Vec3d(INFINITY), Vec3d(-INFINITY)};
    for (const Vec3d& p : places) {
      for (int axis = 0; axis < 3; ++axis) {
        box.minimum[axis] = std::min(box.minimum[axis], p[axis]);
        box.maximum[axis] = std::max(box.maximum[axis], p[axis]);
      }
    }
    return box;
  }
  /// The volume that the triangles enclose, above 0 where they face outwards.
  double volume() const {
    double sum = 0;
    for (const auto& [a, b, c] : triangles) {
      const Vec3d from = places[0];
      sum += dot(places[a] - from, cross(places[b] - from, places[c] - from)) / 6;
    }
    return sum;
  }

  std::vector<Vec3d> places;
  std::vector<Vec3f> vertex_colors, triangle_colors;
  std::vector<Triangle> triangles;
  std::set<std::string> unused;
};

/// All that stream_mesh() reads of a file, which must be sound.
inline KeepingSink kept(const std::string& path) {
  KeepingSink sink;
  const Status status = stream_mesh(path, sink);
  EXPECT_TRUE(status.ok()) << status.error().message;
  return sink;
}

/// The message with which stream_mesh() fails, or "none".
inline std::string error_of(const std::string& path) {
  KeepingSink sink;
  const Status status = stream_mesh(path, sink);
  return status.ok() ? "none" : status.error().message;
}

}  // namespace gvx::io
