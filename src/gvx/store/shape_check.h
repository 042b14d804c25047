/// \file
/// Checks of what a caller says of a tree, before a store is made of it.
#pragma once

#include <cstdint>

#include "gvx/core/result.h"
#include "gvx/store/format.h"

namespace gvx::store {

/// An error unless n is a number of children along an axis, and m a number of voxels along an axis of a
/// brick, that trees can have.
Status check_tree(std::uint32_t n, std::uint32_t m);

/// An error unless the shape is one that TreeShape::covering() makes of a volume of at least one voxel.
Status check_shape(const TreeShape& shape);

}  // namespace gvx::store
