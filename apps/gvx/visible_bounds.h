/// \file
/// visible_bounds: the part of a volume that a picture of it can show.
#pragma once

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/produce/producer.h"
#include "gvx/scene/visibility.h"

namespace gvx::app {

/// In tree space, the box of all that is not hidden within another box; that box itself where all is hidden.
/// It is right up to the voxels of the finest level, or a 64th of the tree's cube in deeper trees. Reads the
/// bricks at the box's faces.
Result<Box3d> visible_bounds(const produce::Producer& producer, const scene::Visibility& visibility,
                             const Box3d& within);

}  // namespace gvx::app
