/// \file
/// TileMarcher: the walk of one tile's rays through the nodes of a tree, nearest first, whatever the voxels
/// are. Private to this room.
#pragma once

#include <algorithm>
#include <cmath>

#include "gvx/exec/tile_grid.h"
#include "gvx/render/reference/march_view.h"
#include "gvx/render/reference/tree_walk.h"
#include "gvx/render/tile/marching_rays.h"
#include "gvx/render/tile/place_bricks.h"
#include "gvx/render/tile/tile_rays.h"
#include "gvx/render/vectors/vectors.h"

namespace gvx::render {

template <int N>
class TileMarcher {
 public:
  /// `projection` is that of a tile of such rays.
  TileMarcher(const TilesView& tiles, const TileProjection& projection, const RaysOfTile& tile)
      : view_(tiles.walk),
        walk_(tiles.walk),
        preview_(tile.preview),
        zones_(has_zones(view_.frame)),
        blends_(view_.frame.format.content != VoxelContent::labels),
        projects_(render::projects(view_.frame)),
        place_bricks_(view_.frame, tiles.bricks, tiles.cells, vectors_for(view_.frame)),
        projection_(projection),
        rays_(tiles, tile) {
    projection_.begin_tile(tile.x0, tile.y0);
    const scene::CameraView& camera = tiles.film.camera;
    if (!camera.orthographic) return;
    const Vec3d forward = view_.frame.world_to_tree.vector(camera.forward);
    for (int axis = 0; axis < 3; ++axis) viewpoint_[axis] = forward[axis] > 0 ? -1e300 : 1e300;
  }

  MarchingRays<N>& rays() { return rays_; }

  /// Marches until no ray has anything to go through, or the deadline.
  void march(exec::Deadline deadline) {
    deadline_ = deadline;
    rays_.begin();
    const ActiveRays begun = rays_.active();
    At root;
    root.cell = view_.frame.bundle.root;
    if (rays_.any_left() && !view_.hidden.at(0, 0)) visit(root, TileRect());
    if (projects_ && !rays_.stopped()) {
      begun.for_each([&](std::uint32_t ray) {
        if (!rays_.is_blocked(ray)) rays_.finish_projecting(ray);
      });
    }
  }

 private:
  /// A node on the way down.
  struct At {
    NodeIndex node, parent;
    int level = 0;
    Vec3d cell;  // counted from the eye's
    int ancestor_level = -1;
    BrickIndex ancestor_slot;  // of the finest node above that has a brick
  };
  /// The levels that steps within a node may be of.
  struct Levels {
    int finest, coarsest;
    double nearest = 0, farthest = 0;  // distances of the node
  };

  /// Goes through a node and all below it, nearest first, with the rays of a rectangle, which may meet it.
  void visit(const At& at, const TileRect& rect) {
    const FrameView& frame = view_.frame;
    const tree::ChildWord child = view_.nodes.child[at.node.value];
    const LevelView& level = frame.bundle.levels[at.level];
    const NodeBox box{level.corner(at.cell), level.corner(at.cell + Vec3d(1))};
    for (int axis = 0; axis < 3; ++axis) {
      if (box.high[axis] <= frame.bundle.box.minimum[axis] || box.low[axis] >= frame.bundle.box.maximum[axis])
        return;
    }
    if (projects_ && rays_.all_outdone(at.node, rect)) return;
    // Rays that go on have passed the nodes before: these are neither kept nor asked for.
    if (rays_.resumed() && !rays_.any_before(box, rect)) return;
    view_.tile_usage.touch(at.node.value / (N * N * N), view_.pass);
    const tree::ContentWord content = view_.nodes.content[at.node.value];
    Place place = place_at(at);
    const Levels levels = levels_in(box);
    if (content.kind() == tree::ContentKind::constant) {
      place.kind = Place::constant;
      // Steps of coarser levels than this node's are taken by nodes above, after those in its siblings.
      return go_through(place, box, rect, levels, levels.finest, std::max(levels.coarsest, at.level));
    }
    const bool has_brick = content.kind() == tree::ContentKind::brick;
    if (levels.finest > at.level && !child.terminal()) {
      At within = at;
      within.parent = at.node;
      if (has_brick) {
        within.ancestor_level = at.level;
        within.ancestor_slot = content.brick();
      }
      if (child.has_children()) {
        visit_children(within, child.children(), box, rect);
      } else {
        place = place_at(within);
        place.lack = cache::kNeedsChildren;
        go_through(place, box, rect, levels, levels.finest, at.level + 1);
        place = place_at(at);
      }
      if (rays_.stopped() || levels.coarsest > at.level) return;
    }
    place.kind = has_brick ? Place::brick : Place::nothing;
    place.lack = has_brick ? 0 : cache::kNeedsBrick;
    place.slot = content.brick();
    place.brick_level = at.level;
    place.finest = child.terminal();
    go_through(place, box, rect, levels, child.terminal() ? levels.finest : at.level, at.level);
  }

  void visit_children(const At& within, TileIndex tile, const NodeBox& box, const TileRect& rect) {
    At child = within;
    child.level = within.level + 1;
    const LevelView& level = view_.frame.bundle.levels[child.level];
    typename TileProjection::Rects rects;
    projection_.project_children(box.low, level.edge_high, N, rects);
    int order[3][N];
    for (int axis = 0; axis < 3; ++axis) {
      order_along((viewpoint_[axis] - box.low[axis]) * level.across, order[axis]);
    }
    const Vec3d first = double(N) * within.cell - level.digit;
    for (const int z : order[2]) {
      for (const int y : order[1]) {
        for (const int x : order[0]) {
          const auto index = static_cast<std::uint32_t>(x + N * (y + N * z));
          if (view_.hidden.at(tile.value, index)) continue;
          TileRect met = rects[index];
          met = {std::max(met.x0, rect.x0), std::min(met.x1, rect.x1), std::max(met.y0, rect.y0),
                 std::min(met.y1, rect.y1)};
          if (met.empty() || !rays_.active().any_in(met)) continue;
          child.node = NodeIndex(tile.value * (N * N * N) + index);
          child.cell = first + Vec3d(x, y, z);
          visit(child, met);
          if (rays_.stopped() || !rays_.any_left()) return;
        }
      }
    }
  }

  /// Children along an axis, those nearer to the eye first; it is at `eye`, in children.
  static void order_along(double eye, int (&order)[N]) {
    const int first = eye < 1 ? 0 : eye >= N - 1 ? N - 1 : static_cast<int>(eye);
    int count = 0;
    order[count++] = first;
    for (int step = 1; step < N; ++step) {
      if (first - step >= 0) order[count++] = first - step;
      if (first + step < N) order[count++] = first + step;
    }
  }

  Place place_at(const At& at) const {
    Place place;
    place.node = at.node;
    place.parent = at.parent;
    place.level = at.level;
    place.cell = at.cell;
    place.ancestor_level = at.ancestor_level;
    place.ancestor_slot = at.ancestor_slot;
    return place;
  }

  /// Certain not to leave out any: a zone may begin and end up to a step late.
  Levels levels_in(const NodeBox& box) const {
    const FrameView& frame = view_.frame;
    if (frame.bundle.fixed_blend >= 0) return {frame.bundle.fixed_level, frame.bundle.fixed_level};
    if (!zones_) return {frame.max_level, frame.max_level};
    const TileProjection::Distances t = projection_.distances(box);
    Levels levels{frame.max_level, frame.max_level, t.nearest, t.farthest};
    while (levels.finest > 0 && t.nearest > zone_ends(levels.finest - 1)) --levels.finest;
    while (levels.coarsest > 0 && t.farthest >= zone_begins(levels.coarsest - 1)) --levels.coarsest;
    return levels;
  }
  double zone_begins(int level) const {
    const double t = view_.frame.bundle.lod_distance[level];
    return t - 1e-9 * std::fabs(t);
  }
  /// Up to where rays may not have noticed yet that the zone of `level` has begun.
  double zone_ends(int level) const {
    const FrameView& frame = view_.frame;
    const double t = frame.bundle.lod_distance[level];
    return t + 1e-9 * std::fabs(t) + 2 * frame.stride_of(level, level > 0) * frame.tick_world;
  }
  bool may_be_zone(int level, bool blended, const Levels& levels) const {
    const FrameView& frame = view_.frame;
    if (level == 0 || !blends_) return !blended;
    if (frame.bundle.fixed_blend >= 0) return blended == (frame.bundle.fixed_blend > 0);
    if (!zones_) return !blended;
    if (level < frame.max_level) return blended;
    return blended ? levels.farthest >= zone_begins(level) : levels.nearest <= zone_ends(level);
  }

  /// All steps of levels from `finest` to `coarsest`: a ray comes from finer ones to coarser ones.
  void go_through(const Place& place, const NodeBox& box, const TileRect& rect, const Levels& levels,
                  int finest, int coarsest) {
    for (int level = finest; level >= coarsest; --level) {
      for (const bool blended : {false, true}) {
        if (rays_.stopped() || !may_be_zone(level, blended, levels)) continue;
        go_through(place, box, rect, level, blended);
      }
    }
  }

  /// Those of one zone.
  void go_through(Place place, const NodeBox& box, const TileRect& rect, int level, bool blended) {
    if (blended && place.kind != Place::constant && place.level == level) {
      place.blended = place.ancestor_level == level - 1;
      place.lacks_coarse = !place.blended;
      place.parent_slot = place.ancestor_slot;
    }
    const bool stops = place.lacks() && !preview_;
    const Place shown = place.lack != 0 && preview_ ? walk_.stand_in(place) : place;
    StretchesWanted wanted;
    wanted.zone = TileRays::zone_number(level, blended);
    wanted.coarser = shown.coarser_than(level);
    wanted.step_level = wanted.coarser ? shown.brick_level : level;
    wanted.stride =
        wanted.coarser ? view_.frame.stride[shown.brick_level] : view_.frame.stride_of(level, blended);
    rays_.batch().blended = false;
    const bool is_brick = shown.kind == Place::brick && !stops;
    const bool seen = is_brick && place_bricks_.prepare(shown, level, wanted, rays_.batch());
    // Cells that cannot be seen are nobody's business, unless rays are counted or have passed them.
    if (is_brick && !seen && !preview_ && !rays_.resumed()) return walk_.touch_bricks(shown);
    rays_.set_out();
    if (!rays_.take(place.node, box, rect, wanted)) return;
    if (place.lacks()) {
      walk_.ask(place, rays_.most_gain());
      if (stops) return rays_.block();
      walk_.ask_for_own(place);
    }
    if (preview_) rays_.count_wanted(place, level);
    if (shown.kind == Place::constant) rays_.gather_constant_matter(walk_.ranges_of(shown));
    if (!is_brick) return;
    walk_.touch_bricks(shown);
    if (!seen) return;
    rays_.gather(shown, wanted, level, projects_ ? walk_.ranges_of(shown) : ChannelRanges());
    // Beginning a tile costs something: one that was begun comes a good part further.
    constexpr int kLeastBatches = 32;
    if (++batches_ >= kLeastBatches && exec::late(deadline_)) rays_.stop();
  }

  const WalkView& view_;
  const TreeWalk<N> walk_;
  const bool preview_;
  const bool zones_;   // there are several along a ray
  const bool blends_;  // levels
  const bool projects_;
  const PlaceBricks<N> place_bricks_;
  TileProjection projection_;
  MarchingRays<N> rays_;
  Vec3d viewpoint_;  // that of the rays, from the eye: very far behind it where they are parallel
  int batches_ = 0;
  exec::Deadline deadline_;
};

}  // namespace gvx::render
