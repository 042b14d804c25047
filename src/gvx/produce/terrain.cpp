#include "gvx/produce/terrain.h"

#include <algorithm>
#include <vector>

#include "gvx/produce/coverage.h"

namespace gvx::produce {

void TerrainField::sample(const VoxelBlock& block, std::span<float> values) const {
  const double width = coverage_width(0, block.spacing);
  thread_local std::vector<double> sums;
  sums.resize(block.edge);
  for_each_row(block, values, [&](Vec3d first, std::span<float> row) {
    const auto above = [&](double noise) { return first.z - options_.sea - options_.relief * noise; };
    options_.noise.row(in_noise(first), block.spacing, block.edge, block.spacing, sums.data(),
                       [&](const double* so_far, double rest) {
                         return std::all_of(so_far, so_far + block.edge, [&](double sum) {
                           return coverage_settled(above(sum), options_.relief * rest, width);
                         });
                       });
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = static_cast<float>(coverage(above(sums[i]), width));
  });
}

ValueRange TerrainField::bounds(const Box3d& box, double coarsest_spacing) const {
  const noise::Interval n =
      options_.noise.bounds({in_noise(box.minimum), in_noise(box.maximum)}, coarsest_spacing);
  constexpr double kMargin = 1e-12;
  const noise::Interval above{box.minimum.z - options_.sea - options_.relief * n.high - kMargin,
                              box.maximum.z - options_.sea - options_.relief * n.low + kMargin};
  const noise::Interval c = coverage_bounds(above, 0, coverage_width(0, coarsest_spacing));
  return {static_cast<float>(c.low), static_cast<float>(c.high)};
}

}  // namespace gvx::produce
