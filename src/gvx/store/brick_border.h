/// \file
/// change_border: a plane of a brick with a narrower border, or a wider one, as bricks in memory have it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>

namespace gvx::store {

/// What lies as far behind `end` as `end` behind `before`, if voxels can have that value.
template <typename Voxel>
Voxel extrapolated(Voxel end, Voxel before) {
  if constexpr (std::is_floating_point_v<Voxel>) {
    const Voxel beyond = 2 * end - before;
    return std::isfinite(beyond) ? beyond : end;
  } else {
    const int beyond = 2 * int{end} - int{before};
    return static_cast<Voxel>(std::clamp(beyond, 0, int{std::numeric_limits<Voxel>::max()}));
  }
}

/// Writes a plane of m^3 voxels with a border of `wanted` to `to`, of one with a border of `stored`. What is
/// beyond that border goes on as the last two voxels do, or where not `linear`, as the last.
template <typename Voxel>
void change_border(const Voxel* from, std::size_t m, std::size_t stored, std::size_t wanted, bool linear,
                   Voxel* to) {
  const std::size_t edge = m + 2 * stored, kept = m + 2 * wanted;
  const std::size_t cut = stored > wanted ? stored - wanted : 0, rim = wanted > stored ? wanted - stored : 0;
  const std::size_t inner = kept - 2 * rim;
  const auto at = [&](std::size_t x, std::size_t y, std::size_t z) { return to + (z * kept + y) * kept + x; };
  for (std::size_t z = 0; z < inner; ++z) {
    for (std::size_t y = 0; y < inner; ++y) {
      const Voxel* row = from + ((z + cut) * edge + y + cut) * edge + cut;
      std::copy(row, row + inner, at(rim, y + rim, z + rim));
    }
  }
  // One axis after the other; what an axis has added is there for the next.
  const std::size_t steps[3] = {1, kept, kept * kept};
  for (std::size_t axis = 0; axis < 3 && rim > 0; ++axis) {
    const std::size_t step = steps[axis], u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto whole = [&](std::size_t other) { return other < axis; };
    for (std::size_t j = whole(v) ? 0 : rim; j < (whole(v) ? kept : kept - rim); ++j) {
      for (std::size_t i = whole(u) ? 0 : rim; i < (whole(u) ? kept : kept - rim); ++i) {
        Voxel* line = to + i * steps[u] + j * steps[v];
        for (std::size_t k = rim; k-- > 0;) {
          Voxel *low = line + k * step, *high = line + (kept - 1 - k) * step;
          *low = linear ? extrapolated(low[step], low[2 * step]) : low[step];
          *high = linear ? extrapolated(*(high - step), *(high - 2 * step)) : *(high - step);
        }
      }
    }
  }
}

}  // namespace gvx::store
