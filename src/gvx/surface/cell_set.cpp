#include "gvx/surface/cell_set.h"

#include <algorithm>
#include <bit>

namespace gvx::surface {

bool CellSet::empty() const {
  return std::all_of(column_.begin(), column_.end(), [](std::uint32_t bits) { return bits == 0; });
}

int CellSet::count() const {
  int count = 0;
  for (const std::uint32_t bits : column_) count += std::popcount(bits);
  return count;
}

std::array<std::uint32_t, kCells * kCells> CellSet::columns(int axis) const {
  if (axis == 2) return column_;
  const GridAxes axes(axis);
  std::array<std::uint32_t, kCells * kCells> turned{};
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      for (std::uint32_t bits = column_[index({x, y, 0})]; bits != 0; bits &= bits - 1) {
        const Cell at = axes.to_grid(Cell(x, y, std::countr_zero(bits)));
        turned[static_cast<std::size_t>(column_at(at.x, at.y))] |= std::uint32_t{1} << at.z;
      }
    }
  }
  return turned;
}

}  // namespace gvx::surface
