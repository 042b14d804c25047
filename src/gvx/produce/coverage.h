/// \file
/// Coverage: how much of a voxel is inside of a surface, from a number that is below 0 inside and changes
/// about as fast as a distance.
#pragma once

#include <algorithm>

#include "gvx/core/noise.h"
#include "gvx/core/voxel.h"

namespace gvx::produce {

/// 1 where t is below -width/2, 0 where it is above width/2, even in between. For a width of 0, 1 at t = 0.
GVX_HD inline double coverage(double t, double width) {
  if (width <= 0) return t <= 0 ? 1 : 0;
  return std::clamp(0.5 - t / width, 0.0, 1.0);
}

/// Is the coverage 0 or 1 wherever between t - rest and t + rest?
inline bool coverage_settled(double t, double rest, double width) {
  return t - rest >= 0.5 * width || t + rest <= -0.5 * width;
}

/// The least width that shows no steps in voxels of this spacing, which must be as wide as the slope.
GVX_HD inline double coverage_width(double wanted, double spacing) {
  return std::max(wanted, 2 * spacing);
}

/// Holds coverage(t, w) for all t of the interval and all w between the two widths.
GVX_HD inline noise::Interval coverage_bounds(noise::Interval t, double least_width, double most_width) {
  // Away from the surface a wide slope is nearer to 1/2 than a narrow one.
  return {coverage(t.high, t.high > 0 ? least_width : most_width),
          coverage(t.low, t.low > 0 ? most_width : least_width)};
}

}  // namespace gvx::produce
