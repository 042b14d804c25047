/// \file
/// TreeWalk: from a step of a ray to the node that holds it, and what rays ask for there. Where a walk ends
/// depends on the step's level and cell alone, so rays whose steps are in one node may share a walk.
#pragma once

#include <cstdint>

#include "gvx/brick/brick_pool.h"
#include "gvx/cache/request_marks.h"
#include "gvx/cache/usage_list.h"
#include "gvx/render/frame/frame.h"
#include "gvx/tree/hidden_nodes.h"
#include "gvx/tree/node_pool.h"

namespace gvx::render {

/// What walks of a pass work on: the tree, whatever its voxels are.
struct WalkView {
  FrameView frame;
  tree::NodePoolView nodes;
  tree::HiddenNodesView hidden;
  cache::UsageView tile_usage, brick_usage;
  cache::RequestView requests;
  std::uint32_t pass = 0;
};

/// Everything a pass of one voxel type, N and M works on, apart from its rays.
template <typename Voxel, int N, int M>
struct PassView : WalkView {
  brick::BrickPoolView<Voxel, M> bricks;
};

/// Where a walk ended.
struct Place {
  enum Kind { transparent, constant, brick, nothing } kind = nothing;
  std::uint32_t lack = 0;  ///< what must be asked for at `node`
  NodeIndex node;
  int level = 0;        ///< of the node
  Vec3d cell;           ///< the node, counted from the eye's (level_view.h): whole numbers
  BrickIndex slot;      ///< of the brick to sample
  int brick_level = 0;  ///< of that brick: the node's, or an ancestor's in a preview
  NodeIndex parent;     ///< of the node, where levels are blended
  BrickIndex parent_slot;
  bool blended = false;       ///< with the parent's brick
  bool lacks_coarse = false;  ///< that brick is not there
  bool finest = false;        ///< there is nothing finer than the brick
  int ancestor_level = -1;    ///< of the finest ancestor with a brick, -1 for none
  BrickIndex ancestor_slot;

  GVX_HD bool lacks() const { return lack != 0 || lacks_coarse; }
  /// Is it a preview's stand-in for a brick of `level`?
  GVX_HD bool coarser_than(int wanted) const { return kind == brick && brick_level < wanted && !finest; }
  /// Does it count how far the voxels that the brick stands for deviate?
  GVX_HD bool deviates(const FrameView& frame, int wanted) const {
    if (brick_level >= frame.max_level) return false;
    // Far coarser than wanted, deviations are of more than a step can tell apart: they would show fog. Of a
    // greatest value they are all that is known.
    return brick_level == wanted || (scene::seeks_extreme(frame.visibility.mode) && !finest);
  }
  /// How many levels the brick is coarser than wanted.
  GVX_HD std::uint32_t lack_of(int wanted) const {
    return static_cast<std::uint32_t>(wanted - (ancestor_level >= 0 ? ancestor_level : 0));
  }
};

/// The way from the root to a node: of each level's node its place among its parent's children.
template <int N>
class PathDown {
 public:
  /// To the node of `level` at `cell`, counted from the eye's.
  GVX_HD PathDown(const LevelView& level, int levels, Vec3d cell) : second_(levels - kMost) {
    constexpr std::uint64_t kNodes = power(kMost);
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint64_t node =
          level.eye[axis] + static_cast<std::uint64_t>(static_cast<std::int64_t>(cell[axis]));
      // The middle: whatever rounding does to it, it stays in the node.
      const auto middle = [](std::uint64_t nodes) { return static_cast<double>(nodes) + 0.5; };
      if (second_ <= 0) {
        at_[axis] = middle(node) / level.across;
      } else {
        at_[axis] = middle(node / kNodes) / static_cast<double>(power(second_));
        later_[axis] = middle(node % kNodes) / static_cast<double>(kNodes);
      }
    }
  }

  /// Goes down to a node of `level`.
  GVX_HD Vec3d down(int level) {
    if (level - 1 == second_) at_ = later_;
    Vec3d digit;
    for (int axis = 0; axis < 3; ++axis) {
      const double scaled = at_[axis] * N;
      const int whole = static_cast<int>(scaled);
      digit[axis] = whole < N ? whole : N - 1;
      at_[axis] = scaled - digit[axis];
    }
    return digit;
  }

 private:
  // As many levels as a double tells nodes apart in.
  static constexpr int kMost = 30;
  GVX_HD static constexpr std::uint64_t power(int exponent) {
    std::uint64_t power = 1;
    for (int i = 0; i < exponent; ++i) power *= N;
    return power;
  }

  int second_;  // the level from which on it is `later_` that counts, if above 0
  Vec3d at_;    // in the node of the present level, or its ancestor of level second_: from 0 to 1
  Vec3d later_;
};

template <int N>
class TreeWalk {
 public:
  GVX_HD explicit TreeWalk(const WalkView& view) : view_(view) {}

  /// To the node of `level` at this cell, or as far towards it as there is anything to see; with its parent
  /// where levels are `blended`. `outdone(node)` says that nothing below a node matters.
  template <typename Outdone>
  GVX_HD Place to(int level, bool blended, Vec3d cell, const Outdone& outdone) const {
    const tree::NodePoolView& nodes = view_.nodes;
    Place place;
    const LevelView* levels = view_.frame.bundle.levels;
    PathDown<N> path(levels[level], level, cell);
    place.cell = view_.frame.bundle.root;
    std::uint32_t tile = 0, index = 0;
    while (true) {
      view_.tile_usage.touch(tile, view_.pass);
      place.node = NodeIndex(tile * (N * N * N) + index);
      if (view_.hidden.at(tile, index) || outdone(place.node)) {
        place.kind = Place::transparent;
        return place;
      }
      const tree::ChildWord child = nodes.child[place.node.value];
      const tree::ContentWord content = nodes.content[place.node.value];
      if (content.kind() == tree::ContentKind::constant) {
        place.kind = Place::constant;
        return place;
      }
      const bool has_brick = content.kind() == tree::ContentKind::brick;
      if (place.level == level || child.terminal()) {
        place.kind = has_brick ? Place::brick : Place::nothing;
        place.lack = has_brick ? 0 : cache::kNeedsBrick;
        place.slot = content.brick();
        place.brick_level = place.level;
        place.finest = child.terminal();
        if (blended && place.level == level) {
          const bool parent_here = place.ancestor_level == place.level - 1;
          place.lacks_coarse = !parent_here;
          place.blended = parent_here;
          place.parent_slot = place.ancestor_slot;
        }
        return place;
      }
      place.parent = place.node;
      if (has_brick) {
        place.ancestor_level = place.level;
        place.ancestor_slot = content.brick();
      }
      if (!child.has_children()) {
        place.lack = cache::kNeedsChildren;
        return place;
      }
      tile = child.children().value;
      ++place.level;
      const Vec3d digit = path.down(place.level);
      index = static_cast<std::uint32_t>(digit.x + N * (digit.y + N * digit.z));
      place.cell = double(N) * place.cell + (digit - levels[place.level].digit);
    }
  }

  /// Asks for what is missing, and keeps the half that is there of two bricks to blend.
  GVX_HD void ask(const Place& place, float priority) const {
    if (place.blended) view_.brick_usage.touch(place.parent_slot.value, view_.pass);
    if (place.lacks_coarse && place.kind == Place::brick) {
      view_.brick_usage.touch(place.slot.value, view_.pass);
    }
    if (place.lack != 0) view_.requests.request(place.node, place.lack, priority);
    if (place.lacks_coarse) view_.requests.request(place.parent, cache::kNeedsBrick, priority);
  }

  /// For previews: what stands in for a place that lacks its brick, the finest resident ancestor's.
  GVX_HD Place stand_in(const Place& lacking) const {
    Place place = lacking;
    place.kind = place.ancestor_level >= 0 ? Place::brick : Place::nothing;
    place.slot = place.ancestor_slot;
    place.brick_level = place.ancestor_level;
    place.finest = false;
    place.blended = false;
    return place;
  }

  /// For previews: asks for the brick of a node on the way down to what is missing.
  GVX_HD void ask_for_own(const Place& place) const {
    if (place.lack == 0) return;
    const bool has_own = view_.nodes.content[place.node.value].kind() == tree::ContentKind::brick;
    if (!has_own) view_.requests.request(place.node, place.lack | cache::kNeedsBrick, 1.0f);
  }

  /// Keeps the bricks of a place that is about to be sampled.
  GVX_HD void touch_bricks(const Place& place) const {
    view_.brick_usage.touch(place.slot.value, view_.pass);
    if (place.blended) view_.brick_usage.touch(place.parent_slot.value, view_.pass);
  }

  /// The value ranges of a place's node.
  GVX_HD ChannelRanges ranges_of(const Place& place) const {
    ChannelRanges values;
    for (std::uint32_t c = 0; c < view_.frame.visibility.channels; ++c) {
      values.channel[c] = view_.nodes.range_of(place.node, c);
    }
    return values;
  }

 private:
  const WalkView& view_;
};

/// Where a brick of `level` that holds a place's node lies in tree space: `across` bricks along an axis, its
/// low corner from the eye.
template <int N>
struct BrickCorner {
  double across;
  Vec3d corner;

  GVX_HD BrickCorner(const FrameView& frame, const Place& place, int level) {
    Vec3d cell = place.cell;
    for (int l = place.level; l > level; --l) cell = frame.bundle.levels[l].parent(cell, N);
    across = frame.bundle.levels[level].across;
    corner = frame.bundle.levels[level].corner(cell);
  }
};

}  // namespace gvx::render
