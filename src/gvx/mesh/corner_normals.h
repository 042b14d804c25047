/// \file
/// Normals of triangles' corners, for meshes of any size: of each the mean of those triangles there that go
/// on smoothly, by their angles (Thuermer and Wuethrich 1998).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <tuple>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/io/external_sort.h"

namespace gvx::mesh {

/// Unit length is 32767; 0 where there is none.
using Normal16 = std::array<std::int16_t, 3>;

/// Takes triangles, then gives their corners' normals in the same order. Corners at equal places are of one
/// vertex: files often repeat one for each of its triangles.
class CornerNormals {
 public:
  /// Sorts so many triangles in memory_bytes and scratch files in `folder`.
  CornerNormals(const std::string& folder, std::uint64_t memory_bytes, std::uint64_t triangles);

  /// Places must be finite.
  Status push(const std::array<Vec3f, 3>& triangle);

  /// Calls function() with the normals of each triangle's corners. Nothing can be pushed afterwards.
  Status for_each(const std::function<Status(const std::array<Normal16, 3>&)>& function);

 private:
  struct Corner {
    std::uint64_t index;  ///< 3 * triangle + which of it
    Vec3f place;
    Vec3f normal;  ///< the triangle's, as long as its angle here

    bool same_place(const Corner& other) const { return place == other.place; }
  };
  struct ByPlace {
    bool operator()(const Corner& a, const Corner& b) const {
      return std::tie(a.place.x, a.place.y, a.place.z, a.index) <
             std::tie(b.place.x, b.place.y, b.place.z, b.index);
    }
  };
  struct Normal {
    std::uint64_t index;
    Normal16 normal;
  };
  struct ByIndex {
    bool operator()(const Normal& a, const Normal& b) const { return a.index < b.index; }
  };
  using Corners = io::ExternalSorter<Corner, ByPlace>;
  using Normals = io::ExternalSorter<Normal, ByIndex>;

  /// Finds the normals around one vertex.
  static Status smooth(std::span<const Corner> around, Normals& normals);

  std::string folder_;
  std::uint64_t memory_bytes_, expected_corners_, triangles_ = 0;
  std::optional<Corners> corners_;
};

}  // namespace gvx::mesh
