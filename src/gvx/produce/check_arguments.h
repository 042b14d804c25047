/// \file
/// What producers check of a tree and of the memory that a caller gives.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "gvx/core/result.h"
#include "gvx/produce/producer.h"

namespace gvx::produce {

/// An error unless a field or a kernel can make the tree's voxels: one channel of scalars, with a scale above
/// 0.
Status check_scalar_tree(const TreeDescription& tree);

/// An error unless the memory is that of one brick.
Status check_brick(const TreeDescription& tree, std::span<const std::byte> voxels);

/// An error unless there is a producer to build on; `what` is what would be built.
Status check_base(const std::shared_ptr<const Producer>& producer, const char* what);

}  // namespace gvx::produce
