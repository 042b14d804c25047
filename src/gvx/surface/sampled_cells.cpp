#include "gvx/surface/sampled_cells.h"

#include <cmath>

namespace gvx::surface {

SampledCells::Sums& SampledCells::sums_of(Cell cell) {
  std::uint16_t& slot = slot_[at(cell)];
  if (slot == 0) {
    cells_.insert(cell);
    sums_.push_back({cell, {}, {}});
    slot = static_cast<std::uint16_t>(sums_.size());
  }
  return sums_[slot - std::size_t{1}];
}

void SampledCells::add(Cell cell, Vec3f normal, Vec3f color) {
  Sums& sums = sums_of(cell);
  const bool front = sums.front.count == 0 || dot(normal, sums.front.normal) >= 0;
  Side& side = front ? sums.front : sums.back;
  side.normal = side.normal + normal;
  side.color = side.color + color;
  side.count += 1;
}

void SampledCells::add_finer(const SampledCells& child, int octant) {
  const Cell corner(octant & 1, octant >> 1 & 1, octant >> 2 & 1);
  for (const Sums& fine : child.sums_) {
    const Cell cell((fine.cell.x + kCells * corner.x) / 2, (fine.cell.y + kCells * corner.y) / 2,
                    (fine.cell.z + kCells * corner.z) / 2);
    // Each cell counts as one, however often it was found.
    const Side& side = fine.kept();
    add(cell, normalize(side.normal), side.color / side.count);
  }
}

SampleAttributes SampledCells::attributes(Cell cell) const {
  const Side& side = sums_[slot_[at(cell)] - std::size_t{1}].kept();
  return pack(normalize(side.normal), side.color / side.count);
}

int SampledCells::primary_axis() const {
  Vec3d sum;
  for (const Sums& sums : sums_) {
    const Vec3f& n = sums.kept().normal;
    sum = sum + Vec3d(std::fabs(double(n.x)), std::fabs(double(n.y)), std::fabs(double(n.z)));
  }
  return sum.x > sum.y && sum.x > sum.z ? 0 : sum.y > sum.z ? 1 : 2;
}

}  // namespace gvx::surface
