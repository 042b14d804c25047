/// \file
/// Whether a mesh encloses anything, and by which rule. Found from its edges, and from faces that occur
/// twice, for most meshes in one pass and a few words of memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/io/mesh.h"

namespace gvx::mesh {

/// How lines that cross a mesh tell what is inside.
enum class InsideRule {
  none,     ///< nothing is: the mesh is open
  winding,  ///< where the surface winds around a place: parts may overlap, cavities are wound the other way
  parity,   ///< behind an odd number of crossings: for faces that are not wound alike
};

/// Hashed sums over the edges of triangles, which say whether edges pair up. Edges between equal places are
/// one edge, whatever their vertices. A sum is 0 by chance with a probability of 2^-128.
class EdgeSums {
 public:
  using Corners = std::array<Vec3d, 3>;

  void add(const Corners& corners);
  /// Adds an edge from a to b; nothing where both are one place.
  void add_edge(Vec3d a, Vec3d b);

  /// Is every edge of an even number of triangles?
  bool even() const { return odd_[0] == 0 && odd_[1] == 0; }
  /// Does every edge go as often one way as the other? So it is where triangles are wound alike.
  bool balanced() const { return ways_[0] == 0 && ways_[1] == 0; }

 private:
  std::array<std::uint64_t, 2> odd_{}, ways_{};
};

/// An edge to be sorted beside its likes: those between the same places, in either direction.
struct EdgeRecord {
  std::array<std::uint64_t, 2> key;
  /// Twice (3 * triangle + which of its edges), and one more where it goes from the lesser place.
  std::uint64_t index;

  /// Nothing where both places are one.
  static std::optional<EdgeRecord> of(Vec3d a, Vec3d b, std::uint64_t edge);

  bool operator<(const EdgeRecord& other) const {
    return std::tie(key, index) < std::tie(other.key, other.index);
  }
};

/// Calls function(record) for the edges of a triangle; it returns a Status. Those between equal places are
/// none.
template <typename Function>
Status for_each_edge(const EdgeSums::Corners& corners, std::uint64_t triangle, const Function& function) {
  for (std::uint64_t k = 0; k < 3; ++k) {
    const auto record = EdgeRecord::of(corners[k], corners[(k + 1) % 3], 3 * triangle + k);
    if (record) GVX_TRY(function(*record));
  }
  return {};
}

/// Finds the edges that do not go as often one way as the other, in records that come in order.
class OpenEdges {
 public:
  void take(const EdgeRecord& record);

  /// 3 * triangle + which of its edges, in order; called once, after the last record. None where there are
  /// more than a million: a surface with so long a border is open.
  std::vector<std::uint64_t> finish();

 private:
  static constexpr std::size_t kMost = 1 << 20;

  void end_edge();

  std::vector<std::uint64_t> same_;  // indices of records of one edge
  std::array<std::uint64_t, 2> key_{};
  std::vector<std::uint64_t> open_;
  bool too_many_ = false;
};

/// A triangle to be sorted beside its likes: those of the same places, in any order.
struct FaceRecord {
  std::array<std::uint64_t, 2> key;
  std::uint64_t index;
  bool flipped;  ///< wound the other way than others of the key that are not

  static FaceRecord of(const EdgeSums::Corners& corners, std::uint64_t index);

  bool operator<(const FaceRecord& other) const {
    return std::tie(key, flipped, index) < std::tie(other.key, other.flipped, other.index);
  }
};

/// Finds a mesh's rule: add() all triangles; where that has not settled it, weld() the open edges; where that
/// has not either, take() the records of all triangles in order, then weigh() all triangles, with the same
/// indices. Triangles without an area count: they may be what closes the mesh.
class InsideJudge {
 public:
  void add(const EdgeSums::Corners& corners);

  /// Is the rule known without looking for faces that occur twice?
  bool settled() const { return welded_ || (all_.balanced() && (faces_[0] != 0 || faces_[1] != 0)); }

  /// May open edges pair up with others of nearly the same places?
  bool may_weld() const { return !all_.even(); }
  /// Compares the open edges anew, and takes places no farther apart than `tolerance` for one. They come from
  /// parts that were each placed by a rounded matrix.
  void weld(std::span<const std::array<Vec3d, 2>> open, double tolerance);

  /// In the order of records. `count` is that of all.
  void take(const FaceRecord& record, std::uint64_t count);
  void weigh(const EdgeSums::Corners& corners, std::uint64_t index);

  InsideRule rule() const;
  /// Should the triangle be left out, because the same face is there already?
  bool is_spare(std::uint64_t index) const;

 private:
  bool drops_copies() const;
  bool drops_backs() const { return !drops_copies() && once_.even(); }
  bool has_backs_only() const { return fronts_ == backs_; }

  EdgeSums all_;
  std::optional<InsideRule> welded_;      // that which the open edges have told
  std::array<std::uint64_t, 2> faces_{};  // 0 where each face is there as often the other way round
  // Found of the records.
  std::array<std::uint64_t, 2> key_{};
  std::array<bool, 2> met_{};             // of the key, either way round
  std::uint64_t fronts_ = 0, backs_ = 0;  // faces that are there, and there both ways round
  std::vector<bool> copies_, back_;       // of triangles: again the same way round, or the other way
  EdgeSums without_copies_, once_;
};

/// The tolerance for weld(): what single precision can tell apart in a mesh of this size.
double weld_distance(const Box3d& bounds);

/// The rule of a mesh that is in memory. Triangles that are to be left out are removed from it.
InsideRule settle_inside(io::TriangleMesh& mesh);

}  // namespace gvx::mesh
