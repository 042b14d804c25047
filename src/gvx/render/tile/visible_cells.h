/// \file
/// visible_cells: which cells of a brick can be seen; a brick has 4 x 4 x 4. Of a set of cells bit
/// x + 4 * (y + 4 * z) is set.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "gvx/brick/brick_layout.h"
#include "gvx/core/voxel.h"

namespace gvx::render {

inline constexpr int kCellsAcross = 4;
inline constexpr int kCells = kCellsAcross * kCellsAcross * kCellsAcross;

/// Between which numbers the trilinear ones in each cell are, and those up to half a number beyond it. NaN is
/// passed over; of a cell of nothing else the least is the greater one.
template <int M, int kBorder, typename Number>
struct CellRanges {
  Number least[kCells], most[kCells];

  explicit CellRanges(const Number* plane) {
    using Layout = brick::BrickLayout<M, kBorder>;
    constexpr int kCell = M / kCellsAcross, kTexels = M + 2;
    for (int cz = 0; cz < kCellsAcross; ++cz) {
      for (int cy = 0; cy < kCellsAcross; ++cy) {
        // Of each column of texels along z and y, then of each cell along x: a cell's values come from its
        // own texels and one more on every side.
        Number low[kTexels], high[kTexels];
        for (int x = 0; x < kTexels; ++x) {
          if constexpr (std::is_floating_point_v<Number>) {
            low[x] = std::numeric_limits<Number>::max();
            high[x] = std::numeric_limits<Number>::lowest();
          } else {
            low[x] = high[x] = plane[Layout::offset(x, cy * kCell, cz * kCell)];
          }
        }
        for (int z = cz * kCell; z < (cz + 1) * kCell + 2; ++z) {
          for (int y = cy * kCell; y < (cy + 1) * kCell + 2; ++y) {
            const Number* row = plane + Layout::offset(0, y, z);
            for (int x = 0; x < kTexels; ++x) {
              low[x] = row[x] < low[x] ? row[x] : low[x];
              high[x] = row[x] > high[x] ? row[x] : high[x];
            }
          }
        }
        for (int cx = 0; cx < kCellsAcross; ++cx) {
          const int cell = cx + kCellsAcross * (cy + kCellsAcross * cz);
          least[cell] = low[cx * kCell];
          most[cell] = high[cx * kCell];
          for (int x = cx * kCell; x < (cx + 1) * kCell + 2; ++x) {
            least[cell] = low[x] < least[cell] ? low[x] : least[cell];
            most[cell] = high[x] > most[cell] ? high[x] : most[cell];
          }
        }
      }
    }
  }
};

/// All but those of which hidden(values, deviation) is true: of the range of the trilinear values in a cell,
/// and the most that they deviate. `deviations` are those of the plane (core/voxel.h), or null for none.
template <int M, typename Voxel, typename Hidden>
std::uint64_t visible_cells(const Voxel* plane, const std::uint8_t* deviations, const Hidden& hidden) {
  const CellRanges<M, kBrickBorder, Voxel> values(plane);
  float unit = 0, deviation[kCells] = {};
  if (deviations != nullptr) std::memcpy(&unit, deviations, sizeof(unit));
  if (unit > 0) {
    const CellRanges<M / 2, 1, std::uint8_t> codes(deviations + sizeof(unit));
    for (int cell = 0; cell < kCells; ++cell) deviation[cell] = unit * deviation_of_code(codes.most[cell]);
  }
  std::uint64_t visible = 0;
  for (int cell = 0; cell < kCells; ++cell) {
    // Of no values: no data, which cannot be seen.
    if (values.most[cell] < values.least[cell]) continue;
    const ValueRange range{static_cast<float>(values.least[cell]), static_cast<float>(values.most[cell])};
    if (!hidden(range, deviation[cell])) visible |= std::uint64_t(1) << cell;
  }
  return visible;
}

/// Those of a brick's cells that touch some of `cells` of the brick of the node above, of which it is the
/// child at `digit`, counted along each axis.
template <int N>
std::uint64_t cells_of_child(std::uint64_t cells, const int (&digit)[3]) {
  std::uint64_t touching = cells;
  for (int axis = 0; axis < 3; ++axis) {
    const int shift = axis == 0 ? 1 : axis == 1 ? kCellsAcross : kCellsAcross * kCellsAcross;
    // The first cell along this axis.
    const std::uint64_t first = axis == 0   ? 0x1111111111111111u
                                : axis == 1 ? 0x000f000f000f000fu
                                            : 0x000000000000ffffu;
    std::uint64_t spread = 0;
    for (int cell = 0; cell < kCellsAcross; ++cell) {
      const int begin = (digit[axis] * kCellsAcross + cell) / N;
      const int last = (digit[axis] * kCellsAcross + cell + 1 + N - 1) / N - 1;
      for (int above = begin; above <= last; ++above) {
        spread |= (touching >> (shift * above) & first) << (shift * cell);
      }
    }
    touching = spread;
  }
  return touching;
}

}  // namespace gvx::render
