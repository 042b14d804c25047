#include "gvx/store/shape_check.h"

#include <string>

namespace gvx::store {

Status check_tree(std::uint32_t n, std::uint32_t m) {
  if (n != 2 && n != 3) {
    return Error{"tree: " + std::to_string(n) + " children along an axis of a node (n); expected 2 or 3"};
  }
  if (m != 8 && m != 16 && m != 32) {
    return Error{"tree: " + std::to_string(m) + " voxels along an axis of a brick (m); expected 8, 16 or 32"};
  }
  return {};
}

Status check_shape(const TreeShape& shape) {
  GVX_TRY(check_tree(shape.n, shape.m));
  const Vec3i d = shape.dimensions;
  constexpr std::int64_t kMost = 0x7fffffff;
  if (min_component(d) < 1 || max_component(d) > kMost) {
    return Error{"tree: a volume of " + std::to_string(d.x) + " x " + std::to_string(d.y) + " x " +
                 std::to_string(d.z) + " voxels; expected 1 to 2147483647 along each axis"};
  }
  const std::uint32_t fitting = TreeShape::covering(d, shape.n, shape.m).levels;
  if (shape.levels != fitting) {
    return Error{"tree: " + std::to_string(shape.levels) + " levels; expected " + std::to_string(fitting) +
                 ", as TreeShape::covering() makes"};
  }
  return {};
}

}  // namespace gvx::store
