/// \file
/// level_views: the levels of a tree around an eye.
#pragma once

#include <vector>

#include "gvx/core/double_double.h"
#include "gvx/core/ray.h"
#include "gvx/render/frame/level_view.h"

namespace gvx::render {

/// Of levels 0 to `max_level` of a tree of arity `n`; `eye` and the visible `box`, which is not empty, are in
/// tree space.
std::vector<LevelView> level_views(int n, int max_level, Vec3dd eye, const Box3d& box);

}  // namespace gvx::render
