#include "gvx/produce/check_arguments.h"

#include <cmath>
#include <string>

#include "gvx/store/shape_check.h"

namespace gvx::produce {

Status check_scalar_tree(const TreeDescription& tree) {
  GVX_TRY(store::check_tree(tree.n, tree.m));
  if (tree.max_level >= std::uint32_t{kMaxLevels}) {
    return Error{"tree: a finest level of " + std::to_string(tree.max_level) + "; expected at most " +
                 std::to_string(kMaxLevels - 1)};
  }
  if (tree.format.content != VoxelContent::scalar || tree.format.planes != 1) {
    return Error{std::string("tree: ") + std::to_string(tree.format.planes) + " planes of " +
                 content_name(tree.format.content) + " voxels; a field has one channel of scalars"};
  }
  if (!(tree.scale > 0) || !std::isfinite(tree.scale) || !std::isfinite(tree.offset)) {
    return Error{"tree: a scale of " + std::to_string(tree.scale) + " and an offset of " +
                 std::to_string(tree.offset) + "; expected a scale above 0, and finite numbers"};
  }
  return {};
}

Status check_brick(const TreeDescription& tree, std::span<const std::byte> voxels) {
  if (voxels.size() == tree.brick_bytes()) return {};
  return Error{"produce: memory of " + std::to_string(voxels.size()) + " bytes; expected brick_bytes(), " +
               std::to_string(tree.brick_bytes())};
}

Status check_base(const std::shared_ptr<const Producer>& producer, const char* what) {
  if (producer != nullptr) return {};
  return Error{std::string(what) + ": the producer is null; expected one to build on"};
}

}  // namespace gvx::produce
