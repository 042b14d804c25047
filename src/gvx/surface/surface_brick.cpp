#include "gvx/surface/surface_brick.h"

#include <algorithm>

namespace gvx::surface {

SurfaceBrick make_brick(const SampledCells& samples) {
  SurfaceBrick brick;
  brick.axis = samples.primary_axis();
  const auto columns = samples.cells().columns(brick.axis);
  brick.grid = make_grid(columns);
  brick.attributes.resize(static_cast<std::size_t>(samples.cells().count()));
  const PrimaryGridView grid = brick.grid.view();
  const GridAxes axes(brick.axis);
  constexpr int kBlock = SurfaceBrickView::kBlock, kBlocks = SurfaceBrickView::kBlocks;
  for (int v = 0; v < kCells; ++v) {
    for (int u = 0; u < kCells; ++u) {
      const std::uint32_t column = columns[static_cast<std::size_t>(column_at(u, v))];
      if (column == 0) continue;
      const int at = u / kBlock + kBlocks * (v / kBlock);
      DepthRange& block = brick.blocks[static_cast<std::size_t>(at)];
      block.least = std::min(block.least, static_cast<std::uint8_t>(lowest_bit(column)));
      block.most = std::max(block.most, static_cast<std::uint8_t>(highest_bit(column)));
      for (std::uint32_t bits = column; bits != 0; bits &= bits - 1) {
        const int w = lowest_bit(bits);
        brick.attributes[grid.rank(u, v, w)] = samples.attributes(axes.from_grid(Cell(u, v, w)));
      }
    }
  }
  return brick;
}

}  // namespace gvx::surface
