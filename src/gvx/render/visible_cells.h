/// \file
/// visible_cells: which cells of a brick can be seen; a brick has 4 x 4 x 4.
#pragma once

#include <cstdint>

#include "gvx/brick/brick_layout.h"
#include "gvx/core/voxel.h"

namespace gvx::render {

inline constexpr int kCellsAcross = 4;

/// Bit x + 4 * (y + 4 * z) is set unless `hidden` is true of the range of the trilinear values in that cell.
template <int M, typename Voxel, typename Hidden>
std::uint64_t visible_cells(const Voxel* plane, const Hidden& hidden) {
  using Layout = brick::BrickLayout<M>;
  constexpr int kCell = M / kCellsAcross;
  std::uint64_t visible = 0;
  for (int cz = 0; cz < kCellsAcross; ++cz) {
    for (int cy = 0; cy < kCellsAcross; ++cy) {
      // Of each column of texels along z and y, then of each cell along x: a cell's values come from its own
      // texels and one more on every side.
      Voxel least[Layout::kEdge], most[Layout::kEdge];
      for (int x = 0; x < Layout::kEdge; ++x)
        least[x] = most[x] = plane[Layout::offset(x, cy * kCell, cz * kCell)];
      for (int z = cz * kCell; z < (cz + 1) * kCell + 2; ++z) {
        for (int y = cy * kCell; y < (cy + 1) * kCell + 2; ++y) {
          const Voxel* row = plane + Layout::offset(0, y, z);
          for (int x = 0; x < Layout::kEdge; ++x) {
            least[x] = row[x] < least[x] ? row[x] : least[x];
            most[x] = row[x] > most[x] ? row[x] : most[x];
          }
        }
      }
      for (int cx = 0; cx < kCellsAcross; ++cx) {
        Voxel low = least[cx * kCell], high = most[cx * kCell];
        for (int x = cx * kCell; x < (cx + 1) * kCell + 2; ++x) {
          low = least[x] < low ? least[x] : low;
          high = most[x] > high ? most[x] : high;
        }
        const int cell = cx + kCellsAcross * (cy + kCellsAcross * cz);
        if (!hidden(ValueRange{static_cast<float>(low), static_cast<float>(high)}))
          visible |= std::uint64_t(1) << cell;
      }
    }
  }
  return visible;
}

}  // namespace gvx::render
