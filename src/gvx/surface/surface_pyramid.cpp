#include "gvx/surface/surface_pyramid.h"

#include <utility>

namespace gvx::surface {
namespace {

constexpr int kArity = 2;

}  // namespace

// The axis whose highest differing bit is the highest says which comes first; z's bits count more than y's,
// and y's more than x's, as in child().
bool before_in_tree(const NodeKey& a, const NodeKey& b) {
  const std::uint64_t differs[3] = {a.x ^ b.x, a.y ^ b.y, a.z ^ b.z};
  int axis = 2;
  for (const int other : {1, 0}) {
    const bool higher = differs[axis] < differs[other] && differs[axis] < (differs[axis] ^ differs[other]);
    if (higher) axis = other;
  }
  return axis == 2 ? a.z < b.z : axis == 1 ? a.y < b.y : a.x < b.x;
}

SurfacePyramid::SurfacePyramid(std::uint32_t finest_level, Take take)
    : finest_(finest_level), take_(std::move(take)), open_(finest_level + std::size_t{1}) {}

Status SurfacePyramid::push(const NodeKey& key, SampledCells samples, TriangleList triangles) {
  if (key.level != finest_ || (last_ && !before_in_tree(*last_, key))) {
    return Error{"surface: bricks come out of their order"};
  }
  last_ = key;
  if (samples.cells().empty()) return {};
  NodeKey above = key;
  for (std::uint32_t level = finest_;; --level, above = parent(above, kArity)) {
    if (open_[level] && !(open_[level]->key == above)) GVX_TRY(close(level));
    if (level == 0) break;
  }
  const std::uint64_t count = triangles.triangles();
  open_[finest_] = Open{key, std::move(samples), 0, std::move(triangles), count};
  return {};
}

Status SurfacePyramid::finish() {
  for (std::uint32_t level = finest_ + 1; level-- > 0;) {
    if (open_[level]) GVX_TRY(close(level));
  }
  return {};
}

Status SurfacePyramid::close(std::uint32_t level) {
  const Open made = std::move(*std::exchange(open_[level], std::nullopt));
  const auto samples = static_cast<std::uint64_t>(made.samples.cells().count());
  // A root that is no leaf keeps its samples: they are what is shown until others are there.
  const bool may_be = !made.resolved_below && (level > 0 || made.children == 0);
  const bool unresolved = may_be && Resolution::unresolved(samples, made.triangles_below);
  GVX_TRY(take_(
      {made.key, made.samples, made.children, unresolved, level == finest_ ? &made.triangles : nullptr}));
  if (level == 0) return {};
  std::optional<Open>& above = open_[level - 1];
  if (!above) above = Open{parent(made.key, kArity), {}};
  const int octant = static_cast<int>(made.key.x % 2 + 2 * (made.key.y % 2) + 4 * (made.key.z % 2));
  above->samples.add_finer(made.samples, octant);
  above->triangles_below += made.triangles_below;
  above->resolved_below = above->resolved_below || !unresolved;
  above->children |= static_cast<std::uint8_t>(1 << octant);
  return {};
}

}  // namespace gvx::surface
