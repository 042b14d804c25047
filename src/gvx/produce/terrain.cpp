#include "gvx/produce/terrain.h"

#include <algorithm>
#include <vector>

namespace gvx::produce {

void TerrainField::sample(const VoxelBlock& block, std::span<float> values) const {
  const double width = coverage_width(0, block.spacing);
  thread_local std::vector<double> sums;
  sums.resize(block.edge);
  for_each_row(block, values, [&](Vec3d first, std::span<float> row) {
    options_.noise.row(options_.in_noise(first), block.spacing, block.edge, block.spacing, sums.data(),
                       [&](const double* so_far, double rest) {
                         return std::all_of(so_far, so_far + block.edge, [&](double sum) {
                           return coverage_settled(options_.above(first.z, sum), options_.relief * rest,
                                                   width);
                         });
                       });
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = static_cast<float>(options_.ground(first, sums[i], block.spacing));
  });
}

}  // namespace gvx::produce
