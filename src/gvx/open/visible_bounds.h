/// \file
/// visible_bounds: the part of a volume that a picture of it can show.
#pragma once

#include <vector>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/produce/producer.h"
#include "gvx/scene/visibility.h"

namespace gvx::open {

/// Both in tree space.
struct VisibleBounds {
  Box3d box;
  /// Points of what is visible, the farthest in many directions: their convex hull holds nearly all of it.
  std::vector<Vec3d> points;
};

/// The bounds of all that is not hidden within a box; that box where all is hidden. They are right up to the
/// voxels of the finest level, or a 64th of the tree's cube in deeper trees. Reads the bricks at the hull.
Result<VisibleBounds> visible_bounds(const produce::Producer& producer, const scene::Visibility& visibility,
                                     const Box3d& within);

}  // namespace gvx::open
