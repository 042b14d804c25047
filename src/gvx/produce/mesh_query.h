/// \file
/// MeshQuery answers what producers ask of a mesh: the nearest point of it, what a line crosses, and whether
/// a place is inside. By Embree's hierarchy of boxes (Wald et al., SIGGRAPH 2014), in single precision:
/// callers place the mesh near the unit cube.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/io/mesh.h"

namespace gvx::produce {

/// Thread-safe once it is made.
class MeshQuery {
 public:
  struct Nearest {
    float distance = 0;
    std::uint32_t triangle = 0;
    std::array<float, 3> weights{};  ///< of the triangle's corners
  };

  /// An error where this build has no Embree or memory does not suffice.
  static Result<std::unique_ptr<MeshQuery>> create(io::TriangleMesh mesh);
  ~MeshQuery();
  MeshQuery(const MeshQuery&) = delete;
  MeshQuery& operator=(const MeshQuery&) = delete;

  const io::TriangleMesh& mesh() const { return mesh_; }

  /// The point of the mesh that is nearest to p; nothing where none is nearer than `radius`.
  std::optional<Nearest> nearest(Vec3f p, float radius) const;

  /// Where the half-line from p along an axis crosses the mesh: the distances, sorted.
  void crossings(Vec3f p, int axis, std::vector<float>& distances) const;

  /// Of the half-line p + t * direction, the least and the greatest t where it crosses the mesh.
  std::optional<std::pair<float, float>> first_and_last(Vec3f p, Vec3f direction) const;

  /// Is p inside? Of three lines through p, most must cross the mesh an odd number of times behind it: so
  /// small holes are seldom seen through.
  bool inside(Vec3f p) const;

 private:
  struct Scene;

  explicit MeshQuery(io::TriangleMesh mesh);

  io::TriangleMesh mesh_;
  std::unique_ptr<Scene> scene_;
};

}  // namespace gvx::produce
