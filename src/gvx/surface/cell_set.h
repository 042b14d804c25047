/// \file
/// CellSet: which cells of a surface brick hold some of the surface. A brick is a cube of kCells^3 cells.
#pragma once

#include <array>
#include <cstdint>

#include "gvx/core/macros.h"
#include "gvx/core/vec.h"

namespace gvx::surface {

inline constexpr int kCells = 32;  ///< along an edge of a brick: the bits of a word

/// A cell of a brick, 0 to kCells - 1 along each axis.
using Cell = Vec3<int>;

/// The axes of a grid whose columns run along `axis`: u and v, in which columns are counted, and w along
/// them.
struct GridAxes {
  int u, v, w;

  GVX_HD explicit constexpr GridAxes(int axis) : u((axis + 1) % 3), v((axis + 2) % 3), w(axis) {}
  template <typename T>
  GVX_HD constexpr Vec3<T> to_grid(Vec3<T> p) const {
    return {p[u], p[v], p[w]};
  }
  template <typename T>
  GVX_HD constexpr Vec3<T> from_grid(Vec3<T> p) const {
    Vec3<T> q;
    q[u] = p.x;
    q[v] = p.y;
    q[w] = p.z;
    return q;
  }
};

/// The place of column (u, v) among all of a grid's, row by row.
GVX_HD constexpr int column_at(int u, int v) {
  return v * kCells + u;
}

class CellSet {
 public:
  /// Columns along z: bit z of column (x, y).
  bool has(Cell c) const { return (column_[index(c)] >> c.z & 1) != 0; }
  void insert(Cell c) { column_[index(c)] |= std::uint32_t{1} << c.z; }
  bool empty() const;
  int count() const;

  /// The columns along an axis, each by column_at() of the axis's grid.
  std::array<std::uint32_t, kCells * kCells> columns(int axis) const;

  bool operator==(const CellSet&) const = default;

 private:
  static std::size_t index(Cell c) { return static_cast<std::size_t>(column_at(c.x, c.y)); }

  std::array<std::uint32_t, kCells * kCells> column_{};
};

}  // namespace gvx::surface
