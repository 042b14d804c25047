/// \file
/// The corners of a box, one by one, and parts of boxes.
#pragma once

#include "gvx/core/ray.h"
#include "gvx/core/vec.h"

namespace gvx {

/// Corner `index`, 0 to 7, of a box: bits 0, 1 and 2 say along which of x, y and z it lies at the maximum.
inline Vec3d box_corner(const Box3d& box, int index) {
  const auto at = [&](int axis) { return (index >> axis & 1) != 0 ? box.maximum[axis] : box.minimum[axis]; };
  return {at(0), at(1), at(2)};
}

/// The part of a box between two places that are given in fractions of it.
inline Box3d box_part(const Box3d& box, const Box3d& fractions) {
  const Vec3d size = box.maximum - box.minimum;
  return {box.minimum + fractions.minimum * size, box.minimum + fractions.maximum * size};
}

}  // namespace gvx
