/// \file
/// What one ray does: descend to the node at its next step, leap over it where it is transparent, gather from
/// its brick and, where levels blend, its parent's, and otherwise ask for what is missing. Two ways to meet
/// missing data: an exact ray stops there and keeps its state; a preview ray makes do with the finest
/// resident ancestor and goes on.
///
/// One scalar ray at a time. The picture is defined here; faster loops must reproduce it (tile_march.h).
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "gvx/brick/brick_pool.h"
#include "gvx/brick/sample.h"
#include "gvx/cache/request_marks.h"
#include "gvx/cache/usage_list.h"
#include "gvx/render/classified.h"
#include "gvx/render/composite.h"
#include "gvx/render/frame.h"
#include "gvx/render/isosurface.h"
#include "gvx/render/projection.h"
#include "gvx/render/ray_state.h"
#include "gvx/render/stretch.h"
#include "gvx/tree/node_pool.h"

namespace gvx::render {

/// Everything a pass works on, apart from its rays.
template <typename Voxel, int N, int M>
struct PassView {
  FrameView frame;
  tree::NodePoolView nodes;
  brick::BrickPoolView<Voxel, M> bricks;
  cache::UsageView tile_usage, brick_usage;
  cache::RequestView requests;
  std::uint32_t pass = 0;
};

template <typename Voxel, int N, int M>
class RayMarcher {
 public:
  GVX_HD RayMarcher(const PassView<Voxel, N, M>& view, double pixel_x, double pixel_y) : view_(view) {
    const FrameView& frame = view.frame;
    ray_world_ = frame.camera.pixel_ray(pixel_x, pixel_y);
    ray_ = {frame.world_to_tree.point(ray_world_.origin), frame.world_to_tree.vector(ray_world_.direction)};
    inside_ = intersect(ray_, frame.box, 0, 1e300);
    for (int axis = 0; axis < 3; ++axis) inverse_direction_[axis] = 1 / ray_.direction[axis];
  }

  /// Goes on until the ray is finished or lacks data, which it then asks for.
  GVX_HD void march_exact(RayState& state) const {
    Stretch<Voxel, M> stretch;
    while (next_stretch(state, stretch)) gather(state, stretch);
  }

  /// Leaps to the ray's next stretch within a brick and puts the state behind it: what is seen there is still
  /// to be gathered. False where the ray is finished or lacks data, which it then asks for.
  GVX_HD bool next_stretch(RayState& state, Stretch<Voxel, M>& stretch) const {
    while (state.phase == RayPhase::under_way) {
      Step step;
      if (!next_step(state, step)) return false;
      const Place place = descend(step, state);
      if (place.lack != 0 || place.lacks_coarse) {
        ask(place, 1 - state.opacity);
        return false;
      }
      if (take(state, step, place, stretch)) return true;
    }
    return false;
  }

  const Ray& ray_world() const { return ray_world_; }

  /// Draws the whole ray with what is resident; asks for what would have been better, coarse levels first.
  GVX_HD PreviewPixel march_preview() const {
    PreviewPixel pixel;
    RayState state;
    while (state.phase == RayPhase::under_way) {
      Step step;
      if (!next_step(state, step)) break;
      Place place = descend(step, state);
      const bool lacking = place.lack != 0 || place.lacks_coarse;
      if (place.kind != Place::transparent) {
        ++pixel.wanted;
        pixel.resident += lacking ? 0 : 1;
      }
      if (lacking) {
        ask(place, 1 - state.opacity);
        if (place.lack != 0) fall_back(step, place, pixel);
      }
      Stretch<Voxel, M> stretch;
      if (take(state, step, place, stretch)) gather(state, stretch);
    }
    pixel.color = state.color;
    pixel.opacity = state.opacity;
    return pixel;
  }

 private:
  /// The next step of a ray and how far steps of its level go on.
  struct Step {
    int level;
    std::int64_t tick, stride;
    std::int64_t zone_end;  ///< the tick at which a coarser level takes over, or begins to be blended in
    bool blended;           ///< some of the next coarser level is seen
    double t_centre;
    Vec3d p;  ///< its centre in tree space
  };

  /// Where a descent ended.
  struct Place {
    enum Kind { transparent, constant, brick, nothing } kind = nothing;
    std::uint32_t lack = 0;  ///< what must be asked for at `node`
    NodeIndex node;
    int level = 0;        ///< of the node
    double across = 1;    ///< nodes of that level along an axis
    double cell[3] = {};  ///< of the node, in nodes of its level
    BrickIndex slot;      ///< of the brick to sample
    int brick_level = 0;  ///< of that brick: the node's, or an ancestor's in a preview
    NodeIndex parent;     ///< of the node, where levels are blended
    BrickIndex parent_slot;
    bool blended = false;       ///< with the parent's brick
    bool lacks_coarse = false;  ///< that brick is not there
    int ancestor_level = -1;    ///< of the finest ancestor with a brick, -1 for none
    BrickIndex ancestor_slot;
  };

  GVX_HD double t_at(double tick) const { return inside_.enter + tick * view_.frame.tick_world; }

  GVX_HD bool next_step(RayState& state, Step& step) const {
    const FrameView& frame = view_.frame;
    step.tick = state.tick;
    int level = frame.level_at(t_at(static_cast<double>(step.tick)));
    while (frame.stride[level] != 1 && step.tick % frame.stride[level] != 0) ++level;
    step.level = level;
    step.stride = frame.stride[level];
    step.t_centre = t_at(static_cast<double>(step.tick) + 0.5 * static_cast<double>(step.stride));
    // A projection has a value wherever there is volume, be it less than half a step of it.
    if (projects() && step.tick == 0 && !(step.t_centre < inside_.exit)) {
      step.t_centre = 0.5 * (inside_.enter + inside_.exit);
    }
    if (inside_.empty() || !(step.t_centre < inside_.exit)) {
      finish(state);
      return false;
    }
    step.zone_end = INT64_MAX;
    step.blended = frame.blends(level, step.t_centre);
    if (level > 0 && frame.fixed_blend < 0) {
      const double from = frame.lod_distance[step.blended ? level - 1 : level];
      const double handover = (from - inside_.enter) / frame.tick_world;
      if (handover < 9e15) {
        const std::int64_t multiple = frame.stride[step.blended ? level - 1 : level];
        const std::int64_t at = whole_above(handover > 0 ? handover : 0);
        const std::int64_t next = at > step.tick ? at : step.tick + 1;
        step.zone_end = (next + multiple - 1) / multiple * multiple;
      }
    }
    step.p = ray_.at(step.t_centre);
    return true;
  }

  /// The least whole number that is no less than x, from 0 to 2^62.
  GVX_HD static std::int64_t whole_above(double x) {
    const auto below = static_cast<std::int64_t>(x);
    return below + (x > static_cast<double>(below) ? 1 : 0);
  }

  GVX_HD RayView ray_view() const { return {view_.frame, ray_world_, -Vec3f(ray_world_.direction)}; }

  GVX_HD bool projects() const {
    const scene::Mode mode = view_.frame.visibility.mode;
    return mode != scene::Mode::composite && mode != scene::Mode::isosurface;
  }

  GVX_HD void finish(RayState& state) const {
    state.phase = RayPhase::finished;
    if (projects()) finish_projection(ray_view(), static_cast<float>(state.tick), state);
  }

  /// Can nothing below a node change what a projecting ray has gathered?
  GVX_HD bool outdone_node(NodeIndex node, RayState& state) const {
    if (!projects()) return false;
    bool all = true;
    for (std::uint32_t c = 0; c < view_.frame.visibility.channels; ++c) {
      all = all && outdone(view_.frame.visibility.mode, state, c, view_.nodes.range_of(node, c));
    }
    return all;
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

  GVX_HD Place descend(const Step& step, RayState& state) const {
    const tree::NodePoolView& nodes = view_.nodes;
    Place place;
    Vec3d x = step.p;
    for (int axis = 0; axis < 3; ++axis) {
      // Rounding, or a ray in the plane of a face, can put a sample a hair outside the volume's box.
      const double low = view_.frame.box.minimum[axis], high = view_.frame.box.maximum[axis] * (1 - 1e-15);
      x[axis] = x[axis] < low ? low : x[axis] < high ? x[axis] : high;
    }
    std::uint32_t tile = 0, index = 0;
    while (true) {
      view_.tile_usage.touch(tile, view_.pass);
      place.node = NodeIndex(tile * (N * N * N) + index);
      const tree::ChildWord child = nodes.child[place.node.value];
      if (child.transparent() || outdone_node(place.node, state)) {
        place.kind = Place::transparent;
        return place;
      }
      const tree::ContentWord content = nodes.content[place.node.value];
      if (content.kind() == tree::ContentKind::constant) {
        place.kind = Place::constant;
        return place;
      }
      const bool has_brick = content.kind() == tree::ContentKind::brick;
      if (place.level == step.level || child.terminal()) {
        place.kind = has_brick ? Place::brick : Place::nothing;
        place.lack = has_brick ? 0 : cache::kNeedsBrick;
        place.slot = content.brick();
        place.brick_level = place.level;
        if (step.blended && place.level == step.level) {
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
      index = 0;
      int factor = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const double scaled = x[axis] * N;
        int digit = static_cast<int>(scaled);
        digit = digit < N ? digit : N - 1;
        x[axis] = scaled - digit;
        place.cell[axis] = place.cell[axis] * N + digit;
        index += static_cast<std::uint32_t>(digit * factor);
        factor *= N;
      }
      ++place.level;
      place.across *= N;
    }
  }

  /// Replaces a lack by the finest resident ancestor's brick, and asks for the node's own brick on the way
  /// down.
  GVX_HD void fall_back(const Step& step, Place& place, PreviewPixel& pixel) const {
    const bool has_own = view_.nodes.content[place.node.value].kind() == tree::ContentKind::brick;
    if (!has_own) view_.requests.request(place.node, place.lack | cache::kNeedsBrick, 1.0f);
    place.kind = place.ancestor_level >= 0 ? Place::brick : Place::nothing;
    place.slot = place.ancestor_slot;
    place.brick_level = place.ancestor_level;
    place.blended = false;
    const auto lack =
        static_cast<std::uint32_t>(step.level - (place.ancestor_level >= 0 ? place.ancestor_level : 0));
    pixel.worst_lack = lack > pixel.worst_lack ? lack : pixel.worst_lack;
  }

  /// Moves the ray behind all steps whose centres are in the node. True where they are in a brick: then
  /// `stretch` is yet to be gathered.
  GVX_HD bool take(RayState& state, const Step& step, const Place& place, Stretch<Voxel, M>& stretch) const {
    // A preview's coarser brick is sampled in its own, longer steps.
    const bool coarser = place.kind == Place::brick && place.brick_level < step.level;
    const int step_level = coarser ? place.brick_level : step.level;
    const std::int64_t stride = view_.frame.stride[step_level];
    const double t_step = view_.frame.tick_world * static_cast<double>(stride);
    double t_exit = inside_.exit;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray_.direction[axis];
      if (d == 0) continue;
      const double face = (place.cell[axis] + (d > 0 ? 1 : 0)) / place.across;
      const double t = (face - ray_.origin[axis]) * inverse_direction_[axis];
      t_exit = t < t_exit ? t : t_exit;
    }
    constexpr double kMostSteps = 1e15;
    const double count = (t_exit - step.t_centre) / t_step;
    std::int64_t steps = whole_above(count > 1 ? (count < kMostSteps ? count : kMostSteps) : 1);
    if (!coarser && step.zone_end != INT64_MAX) {
      const std::int64_t to_zone_end = (step.zone_end - step.tick) / stride;  // both are multiples of it
      steps = steps < to_zone_end ? steps : to_zone_end;
    }

    // Steps within a stretch are counted in floats.
    constexpr std::int64_t kMostInBrick = 1 << 22;
    if (place.kind == Place::brick) steps = steps < kMostInBrick ? steps : kMostInBrick;
    state.tick += steps * stride;
    if (place.kind == Place::constant) gather_constant(state, place, step.level, steps);
    if (place.kind != Place::brick) return false;
    view_.brick_usage.touch(place.slot.value, view_.pass);
    if (place.blended) view_.brick_usage.touch(place.parent_slot.value, view_.pass);
    stretch = stretch_of(step, place, step_level, t_step, steps);
    return true;
  }

  GVX_HD void gather_constant(RayState& state, const Place& place, int level, std::int64_t steps) const {
    const FrameView& frame = view_.frame;
    ChannelRanges values;
    for (std::uint32_t c = 0; c < frame.visibility.channels; ++c) {
      values.channel[c] = view_.nodes.range_of(place.node, c);
    }
    if (frame.format.content == VoxelContent::labels) {
      composite_label(ray_view(), values.channel[0].minimum, level, steps, state);
    } else if (projects()) {
      project_constant(ray_view(), values, level, steps, state);
    } else if (frame.visibility.mode == scene::Mode::composite) {
      composite_constant(ray_view(), values, level, steps, state);
    }
  }

  /// The path of the steps' centres through a brick of `level` that holds the node.
  GVX_HD BrickPath<Voxel, M> path_in(BrickIndex slot, int level, const Step& step, const Place& place,
                                     double t_step) const {
    double shrink = 1;
    for (int l = level; l < place.level; ++l) shrink *= N;
    const double across = place.across / shrink;
    BrickPath<Voxel, M> path;
    path.brick = view_.bricks.brick(slot);
    path.voxels_across = static_cast<float>(across * M);
    for (int axis = 0; axis < 3; ++axis) {
      const auto corner = static_cast<double>(static_cast<std::int64_t>(place.cell[axis] / shrink));
      path.first[axis] = static_cast<float>((step.p[axis] * across - corner) * M);
      path.per_step[axis] = static_cast<float>(ray_.direction[axis] * t_step * across * M);
    }
    return path;
  }

  GVX_HD Stretch<Voxel, M> stretch_of(const Step& step, const Place& place, int step_level, double t_step,
                                      std::int64_t steps) const {
    Stretch<Voxel, M> s;
    s.steps = steps;
    s.level = step_level;
    s.t_centre = step.t_centre;
    s.t_step = t_step;
    s.fine = path_in(place.slot, place.brick_level, step, place, t_step);
    // Far coarser than wanted, deviations are of more than a step can tell apart: they would show fog.
    s.fine_deviates = place.brick_level < view_.frame.max_level && place.brick_level == step.level;
    s.blended = place.blended;
    if (s.blended) s.coarse = path_in(place.parent_slot, place.level - 1, step, place, t_step);
    return s;
  }

  GVX_HD void gather(RayState& state, const Stretch<Voxel, M>& s) const {
    const FrameView& frame = view_.frame;
    const RayView ray = ray_view();
    if constexpr (std::is_same_v<Voxel, std::uint8_t>) {
      if (frame.format.content == VoxelContent::color) return composite_colors<false>(ray, s, state);
      if (frame.format.content == VoxelContent::color_normal) return composite_colors<true>(ray, s, state);
    }
    if constexpr (!std::is_same_v<Voxel, float>) {
      if (frame.format.content == VoxelContent::labels) return composite_labels(ray, s, state);
    }
    if (projects()) return project_stretch(ray, s, state);
    if (frame.visibility.mode == scene::Mode::isosurface) return find_surface(ray, s, state);
    if (frame.visibility.channels == 1) return composite_scalars<1>(ray, s, state);
    composite_scalars<kMaxChannels>(ray, s, state);
  }

  const PassView<Voxel, N, M>& view_;
  Ray ray_world_;
  Ray ray_;                  // in tree space; t is the distance in the world
  Vec3d inverse_direction_;  // infinite where a direction is 0
  RayInterval inside_;       // of the visible volume
};

}  // namespace gvx::render
