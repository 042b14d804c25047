/// \file
/// Whether a mesh encloses anything, and what: found from its edges and from faces that are there twice, in
/// one pass and a few words of memory for most meshes.
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

namespace gvx::produce {

/// How lines that cross a mesh tell what is inside.
enum class InsideRule {
  none,     ///< nothing is: the mesh is open
  winding,  ///< where the surface winds around a place: parts may overlap, cavities are wound the other way
  parity,   ///< behind an odd number of crossings: for faces that are not wound alike
};

/// Sums over the edges of triangles; edges between equal places are one, whatever vertices they are of. That
/// sums are 0 by chance is as likely as to guess 128 bits.
class EdgeSums {
 public:
  using Corners = std::array<Vec3d, 3>;

  void add(const Corners& corners);
  /// One that goes from a to b; none where both are one place.
  void add_edge(Vec3d a, Vec3d b);

  /// Is every edge of an even number of triangles?
  bool even() const { return odd_[0] == 0 && odd_[1] == 0; }
  /// Does every edge go as often one way as the other? So it is where triangles are wound alike.
  bool balanced() const { return ways_[0] == 0 && ways_[1] == 0; }

 private:
  std::array<std::uint64_t, 2> odd_{}, ways_{};
};

/// An edge for comparison with others: by its places, whichever comes first.
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

/// A triangle for comparison with others: by its places, whichever comes first.
struct FaceRecord {
  std::array<std::uint64_t, 2> key;
  std::uint64_t index;
  bool flipped;  ///< wound the other way than others of the key that are not

  static FaceRecord of(const EdgeSums::Corners& corners, std::uint64_t index);

  bool operator<(const FaceRecord& other) const {
    return std::tie(key, flipped, index) < std::tie(other.key, other.flipped, other.index);
  }
};

/// Tells a mesh's rule. First all triangles are added. Where that does not settle it, open edges may be
/// welded. Where that does not either, triangles' records are taken in order, then all are weighed, with the
/// same indices. Triangles without an area count: they may be what closes it.
class InsideJudge {
 public:
  void add(const EdgeSums::Corners& corners);

  /// Without looking at what is there twice.
  bool settled() const { return welded_ || (all_.balanced() && (faces_[0] != 0 || faces_[1] != 0)); }

  /// Are there edges that other ones, of nearly the same places, may go with?
  bool may_weld() const { return !all_.even(); }
  /// Compares the open edges anew, places that are no farther apart than this taken for one: of two parts,
  /// each placed by a rounded matrix.
  void weld(std::span<const std::array<Vec3d, 2>> open, double tolerance);

  /// In the order of records. `count` is that of all.
  void take(const FaceRecord& record, std::uint64_t count);
  void weigh(const EdgeSums::Corners& corners, std::uint64_t index);

  InsideRule rule() const;
  /// Is the triangle one that the rule has no use for, because its like is there?
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

/// Places that are so near to each other are one: what single precision tells apart in a mesh of this size.
double weld_distance(const Box3d& bounds);

/// The rule of a mesh that is in memory. Triangles that it has no use for are taken out.
InsideRule settle_inside(io::TriangleMesh& mesh);

}  // namespace gvx::produce
