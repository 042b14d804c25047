#include "gvx/render/frame/bundle.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/render/frame/level_views.h"

namespace gvx::render {
namespace {

/// Of cones that are as wide everywhere: the coarsest level that is fine enough, and how much of the next.
void fix_level(double width, int n, int max_level, const LevelWidths& widths, BundleView& v) {
  for (int level = max_level; level >= 0; --level) {
    const double wide_enough = widths.finest * widths.stride[level];
    if (wide_enough > width) return;
    v.fixed_level = level;
    const double coarser = wide_enough * n;
    const double share = (width - wide_enough) / (coarser - wide_enough);
    v.fixed_blend = level > 0 ? static_cast<float>(std::min(share, 1.0)) : 0.0f;
  }
}

}  // namespace

Bundle::Bundle(const exec::Device& device, const tree::TreeDescription& tree, const Box3d& visible,
               Vec3dd origin, ConeShape cones, const LevelWidths& widths) {
  const int n = static_cast<int>(tree.n), max_level = static_cast<int>(tree.max_level);
  const Vec3dd here = point(inverse(tree.tree_to_world), origin);
  view_.origin_world = Vec3d(origin);
  view_.origin = Vec3d(here);
  view_.box = {Vec3d(Vec3dd(visible.minimum) - here), Vec3d(Vec3dd(visible.maximum) - here)};
  view_.root = -Vec3d(Vec3dd(floor(here.x), floor(here.y), floor(here.z)));
  const std::vector<LevelView> levels = level_views(n, max_level, here, visible);
  levels_ = exec::Buffer<LevelView>(device, levels.size());
  levels_.write(0, levels);
  view_.levels = levels_.view().data;
  std::fill(std::begin(view_.lod_distance), std::begin(view_.lod_distance) + max_level + 1,
            std::numeric_limits<double>::infinity());
  if (widths.finest_alone) return;
  if (!(cones.growth > 0)) {
    fix_level(cones.width, n, max_level, widths, view_);
    return;
  }
  view_.apex = -cones.width / cones.growth;
  for (int level = 0; level <= max_level; ++level) {
    view_.lod_distance[level] = view_.apex + widths.finest * widths.stride[level] / cones.growth;
  }
}

}  // namespace gvx::render
