#include "visible_bounds.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace gvx::app {
namespace {

constexpr std::uint32_t kDeepest = 6;  // level of the nodes that are looked at
constexpr std::size_t kMostBricks = 4096;

class BoundsFinder {
 public:
  BoundsFinder(const produce::Producer& producer, const scene::Visibility& visibility, const Box3d& within)
      : producer_(producer), tree_(producer.description()), visibility_(visibility), within_(within) {}

  Status find(const NodeKey& key) {
    const Box3d node = box_of(key);
    if (node.empty() || holds(node)) return {};
    const NodeKey one = producer_.canonical(key);
    tree::NodeInfo info;
    GVX_TRY(producer_.describe(std::span(&one, 1), std::span(&info, 1)));
    if (visibility_.hides(info.ranges)) return {};
    const bool finest = info.terminal || key.level == tree_.max_level;
    if (info.ranges.constant() || (key.level >= kDeepest && !finest)) {
      join(node);
      return {};
    }
    if (finest) return look_into(key, one, node);
    const int n = static_cast<int>(tree_.n);
    for (int i = 0; i < n * n * n; ++i) GVX_TRY(find(child(key, n, i)));
    return {};
  }

  const Box3d& bounds() const { return some_ ? bounds_ : within_; }

 private:
  Box3d box_of(const NodeKey& key) const {
    const double across = nodes_across(static_cast<int>(tree_.n), key.level);
    const Vec3d low = corner(key) / across;
    return intersect(Box3d{low, low + Vec3d(1 / across)}, within_);
  }

  bool holds(const Box3d& box) const {
    bool all = some_;
    for (int axis = 0; axis < 3; ++axis) {
      all = all && bounds_.minimum[axis] <= box.minimum[axis] && box.maximum[axis] <= bounds_.maximum[axis];
    }
    return all;
  }

  void join(const Box3d& box) {
    if (box.empty()) return;
    if (!some_) bounds_ = box;
    some_ = true;
    for (int axis = 0; axis < 3; ++axis) {
      bounds_.minimum[axis] = std::min(bounds_.minimum[axis], box.minimum[axis]);
      bounds_.maximum[axis] = std::max(bounds_.maximum[axis], box.maximum[axis]);
    }
  }

  /// Joins the voxels that are seen, of the brick that `one` stands for.
  Status look_into(const NodeKey& key, const NodeKey& one, const Box3d& node) {
    if (++bricks_ > kMostBricks) {
      join(node);
      return {};
    }
    brick_.assign(tree_.brick_bytes(), std::byte{0});
    GVX_TRY(producer_.produce(one, brick_));
    with_voxel_type(tree_.format.type, [&](auto zero) { join_voxels<decltype(zero)>(key); });
    return {};
  }

  template <typename Voxel>
  void join_voxels(const NodeKey& key) {
    const std::size_t m = tree_.m, border = kBrickBorder, edge = m + 2 * border, texels = plane_texels(m);
    const double voxel = 1 / (nodes_across(static_cast<int>(tree_.n), key.level) * static_cast<double>(m));
    const Vec3d low = static_cast<double>(m) * voxel * corner(key);
    const auto value = [&](std::size_t plane, std::size_t at) {
      Voxel v;
      std::memcpy(&v, brick_.data() + (plane * texels + at) * sizeof(Voxel), sizeof(Voxel));
      return static_cast<float>(v);
    };
    const bool colors = tree_.format.planes >= 4 && tree_.format.content != VoxelContent::scalar;
    const std::uint32_t channels = tree_.format.channels();
    for (std::size_t z = 0; z < m; ++z) {
      for (std::size_t y = 0; y < m; ++y) {
        for (std::size_t x = 0; x < m; ++x) {
          const std::size_t at = ((z + border) * edge + y + border) * edge + x + border;
          ChannelRanges ranges;
          bool known = true;
          for (std::uint32_t c = 0; c < channels; ++c) {
            // Surfaces lie between a voxel and the next.
            const std::size_t plane = colors ? 3 : c;
            const float here = value(plane, at);
            known = known && !std::isnan(here);
            ranges.channel[c] = {here, here};
            if (visibility_.mode != scene::Mode::isosurface) continue;
            for (const std::size_t step : {std::size_t{1}, edge, edge * edge}) {
              const float next = value(plane, at + step);
              if (!std::isnan(next)) ranges.channel[c].include({next, next});
            }
          }
          if (!known || visibility_.hides(ranges)) continue;
          const Vec3d first = low + voxel * Vec3d(double(x), double(y), double(z));
          join(intersect(Box3d{first, first + Vec3d(voxel)}, within_));
        }
      }
    }
  }

  const produce::Producer& producer_;
  const produce::TreeDescription& tree_;
  const scene::Visibility& visibility_;
  Box3d within_, bounds_;
  bool some_ = false;
  std::size_t bricks_ = 0;
  std::vector<std::byte> brick_;
};

}  // namespace

Result<Box3d> visible_bounds(const produce::Producer& producer, const scene::Visibility& visibility,
                             const Box3d& within) {
  BoundsFinder finder(producer, visibility, within);
  GVX_TRY(finder.find({}));
  return finder.bounds();
}

}  // namespace gvx::app
