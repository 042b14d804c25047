#include "gvx/open/visible_bounds.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

namespace gvx::open {
namespace {

constexpr std::uint32_t kDeepest = 6;  // level of the nodes that are looked at
constexpr std::size_t kMostBricks = 4096;

/// Evenly over the sphere, by the golden angle; and along the axes.
std::vector<Vec3d> directions() {
  constexpr int kCount = 128;
  std::vector<Vec3d> all = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (int i = 0; i < kCount; ++i) {
    const double z = 1 - (2 * i + 1.0) / kCount, r = std::sqrt(1 - z * z),
                 turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
    all.emplace_back(r * std::cos(turn), r * std::sin(turn), z);
  }
  return all;
}

/// Of a box the corner that is farthest in a direction.
Vec3d corner_towards(const Box3d& box, Vec3d direction) {
  Vec3d corner;
  for (int axis = 0; axis < 3; ++axis)
    corner[axis] = direction[axis] > 0 ? box.maximum[axis] : box.minimum[axis];
  return corner;
}

class BoundsFinder {
 public:
  BoundsFinder(const produce::Producer& producer, const scene::Visibility& visibility, const Box3d& within)
      : producer_(producer),
        tree_(producer.description()),
        visibility_(visibility),
        within_(within),
        directions_(directions()),
        farthest_(directions_.size(), -INFINITY),
        points_(directions_.size()) {}

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

  VisibleBounds bounds() const {
    if (!std::isfinite(farthest_.front())) return {within_, {}};
    // The first six directions are those of the axes.
    return {{{points_[1].x, points_[3].y, points_[5].z}, {points_[0].x, points_[2].y, points_[4].z}},
            points_};
  }

 private:
  Box3d box_of(const NodeKey& key) const {
    const double across = nodes_across(static_cast<int>(tree_.n), key.level);
    const Vec3d low = corner(key) / across;
    return intersect(Box3d{low, low + Vec3d(1 / across)}, within_);
  }

  /// Is nothing of a box farther out than what is known, in any direction?
  bool holds(const Box3d& box) const {
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      if (dot(corner_towards(box, directions_[i]), directions_[i]) > farthest_[i]) return false;
    }
    return true;
  }

  void join(const Box3d& box) {
    if (box.empty()) return;
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      const Vec3d corner = corner_towards(box, directions_[i]);
      const double reach = dot(corner, directions_[i]);
      if (reach <= farthest_[i]) continue;
      farthest_[i] = reach;
      points_[i] = corner;
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
        std::size_t first_seen = m, end_seen = 0;  // of the row
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
          first_seen = std::min(first_seen, x);
          end_seen = x + 1;
        }
        if (first_seen >= end_seen) continue;
        const Vec3d from{double(first_seen), double(y), double(z)},
            to{double(end_seen), double(y + 1), double(z + 1)};
        join(intersect(Box3d{low + voxel * from, low + voxel * to}, within_));
      }
    }
  }

  const produce::Producer& producer_;
  const produce::TreeDescription& tree_;
  const scene::Visibility& visibility_;
  const Box3d within_;
  const std::vector<Vec3d> directions_;
  std::vector<double> farthest_;  // in each direction
  std::vector<Vec3d> points_;     // that are so far
  std::size_t bricks_ = 0;
  std::vector<std::byte> brick_;
};

}  // namespace

Result<VisibleBounds> visible_bounds(const produce::Producer& producer, const scene::Visibility& visibility,
                                     const Box3d& within) {
  BoundsFinder finder(producer, visibility, within);
  GVX_TRY(finder.find({}));
  return finder.bounds();
}

}  // namespace gvx::open
