/// \file
/// MeshQuery answers what producers ask of a mesh: the nearest point of it, what a line crosses, and whether
/// a place is inside. By Embree's hierarchy of boxes (Wald et al., SIGGRAPH 2014), in single precision:
/// callers place the mesh near the unit cube.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/io/mesh.h"
#include "gvx/mesh/mesh_inside.h"

namespace gvx::mesh {

/// Thread-safe once it is made.
class MeshQuery {
 public:
  struct Nearest {
    float distance = 0;
    std::uint32_t triangle = 0;
    std::array<float, 3> weights{};  ///< of the triangle's corners
  };

  struct Crossing {
    float distance = 0;
    int turn = 0;  ///< 1 where the line comes to a triangle's front and so enters, -1 where it leaves

    bool operator<(const Crossing& other) const { return distance < other.distance; }
  };

  /// Of a mesh whose origin is 0, the inside of which its rule tells; where there is no rule it is guessed by
  /// parity. An error where this build has no Embree or memory does not suffice.
  static Result<std::unique_ptr<MeshQuery>> create(io::TriangleMesh mesh,
                                                   InsideRule rule = InsideRule::parity);
  ~MeshQuery();
  MeshQuery(const MeshQuery&) = delete;
  MeshQuery& operator=(const MeshQuery&) = delete;

  const io::TriangleMesh& mesh() const { return mesh_; }

  /// The point of the mesh that is nearest to p; nothing where none is nearer than `radius`.
  std::optional<Nearest> nearest(Vec3f p, float radius) const;

  /// The same of those points, one for each triangle, that `holds` says yes to; it is called with the
  /// distance, the triangle and the weights. Points that lie close to one that it said no to are passed over.
  std::optional<Nearest> nearest_that(Vec3f p, float radius,
                                      const std::function<bool(const Nearest&)>& holds) const;

  /// The place of a point that was found.
  Vec3f place(const Nearest& found) const;

  /// Where the half-line from p along an axis crosses the mesh, sorted by distance.
  void crossings(Vec3f p, int axis, std::vector<Crossing>& crossings) const;

  /// Of sorted crossings of a line that comes from outside: does it end outside, too? Of a mesh with an
  /// inside, another line is worth a try where it does not.
  bool ends_outside(const std::vector<Crossing>& crossings) const;

  /// The distances at which such a line goes from outside to inside, or back.
  void changes(const std::vector<Crossing>& crossings, std::vector<float>& distances) const;

  /// Of the half-line p + t * direction, the least and the greatest t where it crosses the mesh.
  std::optional<std::pair<float, float>> first_and_last(Vec3f p, Vec3f direction) const;

  /// Is p inside? Most of three lines through p must say so: small holes are then seldom seen through.
  bool inside(Vec3f p) const;

  /// Do crossings from a place on, to infinity, say that it is inside?
  bool tells_inside(std::span<const Crossing> crossings) const;

 private:
  struct Scene;

  MeshQuery(io::TriangleMesh mesh, InsideRule rule);

  io::TriangleMesh mesh_;
  InsideRule rule_;
  std::unique_ptr<Scene> scene_;
};

}  // namespace gvx::mesh
