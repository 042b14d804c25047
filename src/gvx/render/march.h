/// \file
/// What one ray does: descend to the node at its next sample, leap over it where it is transparent, march its
/// brick where it is resident, and otherwise ask for what is missing. Two ways to meet missing data: an exact
/// ray stops there and keeps its state; a preview ray makes do with the finest resident ancestor and goes on.
///
/// One scalar ray at a time. The picture is defined here; faster loops must reproduce it.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/brick/brick_pool.h"
#include "gvx/brick/sample.h"
#include "gvx/cache/request_marks.h"
#include "gvx/cache/usage_list.h"
#include "gvx/render/frame.h"
#include "gvx/render/ray_state.h"
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

/// A ray stops when no more than this is left to see: a quarter of a step of 8 bits.
inline constexpr float kOpaque = 1.0f - 1.0f / 1024;

template <typename Voxel, int N, int M>
class RayMarcher {
 public:
  GVX_HD RayMarcher(const PassView<Voxel, N, M>& view, double pixel_x, double pixel_y) : view_(view) {
    const FrameView& frame = view.frame;
    const Ray ray_world = frame.camera.pixel_ray(pixel_x, pixel_y);
    ray_ = {frame.world_to_tree.point(ray_world.origin), frame.world_to_tree.vector(ray_world.direction)};
    to_eye_ = -Vec3f(ray_world.direction);
    inside_ = intersect(ray_, frame.box, 0, 1e300);
  }

  /// Goes on until the ray is finished or lacks data, which it then asks for.
  GVX_HD void march_exact(RayState& state) const {
    while (state.phase == RayPhase::under_way) {
      Step step;
      if (!next_step(state, step)) return;
      const Place place = descend(step);
      if (place.lack != 0) {
        view_.requests.request(place.node, place.lack, 1 - state.opacity);
        return;
      }
      take(state, step, place);
    }
  }

  /// Draws the whole ray with what is resident; asks for what would have been better, coarse levels first.
  GVX_HD PreviewPixel march_preview() const {
    PreviewPixel pixel;
    RayState state;
    while (state.phase == RayPhase::under_way) {
      Step step;
      if (!next_step(state, step)) break;
      Place place = descend(step);
      if (place.kind != Place::transparent) {
        ++pixel.wanted;
        pixel.resident += place.lack == 0 ? 1 : 0;
      }
      if (place.lack != 0) {
        view_.requests.request(place.node, place.lack, 1 - state.opacity);
        fall_back(step, place, pixel);
      }
      take(state, step, place);
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
    std::int64_t zone_end;  ///< the tick at which a coarser level takes over
    double t_centre;        ///< of its sample
    Vec3d p;                ///< of its sample, in tree space
  };

  /// Where a descent ended.
  struct Place {
    enum Kind { transparent, constant, brick, nothing } kind = nothing;
    std::uint32_t lack = 0;  ///< what must be asked for at `node`
    NodeIndex node;
    int level = 0;            ///< of the node
    double cell[3] = {};      ///< of the node, in nodes of its level
    BrickIndex slot;          ///< of the brick to sample
    int brick_level = 0;      ///< of that brick: the node's, or an ancestor's in a preview
    int ancestor_level = -1;  ///< of the finest ancestor with a brick, -1 for none
    BrickIndex ancestor_slot;
  };

  GVX_HD double t_at(double tick) const { return inside_.enter + tick * view_.frame.tick_world; }

  GVX_HD bool next_step(RayState& state, Step& step) const {
    const FrameView& frame = view_.frame;
    step.tick = state.tick;
    int level = frame.level_at(t_at(static_cast<double>(step.tick)));
    while (step.tick % frame.stride[level] != 0) ++level;
    step.level = level;
    step.stride = frame.stride[level];
    step.t_centre = t_at(static_cast<double>(step.tick) + 0.5 * static_cast<double>(step.stride));
    if (inside_.empty() || !(step.t_centre < inside_.exit)) {
      state.phase = RayPhase::finished;
      return false;
    }
    step.zone_end = INT64_MAX;
    if (level > 0) {
      const double handover = (frame.lod_distance[level - 1] - inside_.enter) / frame.tick_world;
      if (handover < 9e15) {
        const std::int64_t coarser = frame.stride[level - 1];
        const auto at = static_cast<std::int64_t>(std::ceil(handover > 0 ? handover : 0));
        const std::int64_t next = at > step.tick ? at : step.tick + 1;
        step.zone_end = (next + coarser - 1) / coarser * coarser;
      }
    }
    step.p = ray_.at(step.t_centre);
    return true;
  }

  GVX_HD Place descend(const Step& step) const {
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
      if (child.transparent()) {
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
        return place;
      }
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
    const auto lack =
        static_cast<std::uint32_t>(step.level - (place.ancestor_level >= 0 ? place.ancestor_level : 0));
    pixel.worst_lack = lack > pixel.worst_lack ? lack : pixel.worst_lack;
  }

  /// Samples, or leaps over, all steps whose samples are in the node, and moves the ray behind them.
  GVX_HD void take(RayState& state, const Step& step, const Place& place) const {
    // A preview's coarser brick is sampled in its own, longer steps.
    const bool coarser = place.kind == Place::brick && place.brick_level < step.level;
    const int step_level = coarser ? place.brick_level : step.level;
    const std::int64_t stride = view_.frame.stride[step_level];
    const double t_step = view_.frame.tick_world * static_cast<double>(stride);
    const double across = nodes_across(N, static_cast<std::uint32_t>(place.level));

    double t_exit = inside_.exit;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray_.direction[axis];
      if (d == 0) continue;
      const double face = (place.cell[axis] + (d > 0 ? 1 : 0)) / across;
      const double t = (face - ray_.origin[axis]) / d;
      t_exit = t < t_exit ? t : t_exit;
    }
    double count = std::ceil((t_exit - step.t_centre) / t_step);
    count = count > 1 ? count : 1;
    const std::int64_t steps_to_zone_end = (step.zone_end - step.tick) / stride;  // both are multiples of it
    const auto to_zone_end = static_cast<double>(steps_to_zone_end);
    count = count < to_zone_end || coarser ? count : to_zone_end;
    const auto steps = static_cast<std::int64_t>(count < 1e15 ? count : 1e15);

    if (place.kind == Place::constant) {
      gather_constant(state, view_.nodes.range[place.node.value].minimum, step.level, steps);
    } else if (place.kind == Place::brick) {
      view_.brick_usage.touch(place.slot.value, view_.pass);
      gather_brick(state, step, place, step_level, t_step, steps);
    }
    state.tick += steps * stride;
  }

  GVX_HD void add(RayState& state, Vec3f color, float opacity) const {
    const float weight = (1 - state.opacity) * opacity;
    state.color = state.color + weight * color;
    state.opacity += weight;
    if (state.opacity >= kOpaque) state.phase = RayPhase::finished;
  }

  GVX_HD void gather_constant(RayState& state, float value, int level, std::int64_t steps) const {
    const scene::TransferView& function = view_.frame.function;
    const auto at = function.place(value);
    const float opacity = function.opacity(at, level);
    ++state.samples;
    if (opacity <= 0) return;
    const float all = 1 - std::pow(1 - opacity, static_cast<float>(steps));
    add(state, function.color(at), all);
  }

  GVX_HD void gather_brick(RayState& state, const Step& step, const Place& place, int step_level,
                           double t_step, std::int64_t steps) const {
    const FrameView& frame = view_.frame;
    const Voxel* voxels = view_.bricks.brick(place.slot);
    const double across = nodes_across(N, static_cast<std::uint32_t>(place.brick_level));
    const double shrink = nodes_across(N, static_cast<std::uint32_t>(place.level - place.brick_level));
    Vec3f p, dp;
    for (int axis = 0; axis < 3; ++axis) {
      const double corner = std::floor(place.cell[axis] / shrink);
      p[axis] = static_cast<float>((step.p[axis] * across - corner) * M);
      dp[axis] = static_cast<float>(ray_.direction[axis] * t_step * across * M);
    }
    for (std::int64_t i = 0; i < steps; ++i) {
      const Vec3f q = p + static_cast<float>(i) * dp;
      const float value = brick::sample<M>(voxels, q);
      const auto at = frame.function.place(value);
      const float opacity = frame.function.opacity(at, step_level);
      ++state.samples;
      if (opacity <= 0) continue;
      Vec3f color = frame.function.color(at);
      if (frame.lighting.enabled) color = lit(color, brick::gradient<M>(voxels, q));
      add(state, color, opacity);
      if (state.phase == RayPhase::finished) return;
    }
  }

  GVX_HD Vec3f lit(Vec3f color, Vec3f gradient_voxel) const {
    const float steep = length(gradient_voxel);
    const Vec3f gradient_world = Vec3f(view_.frame.world_to_tree.transposed_vector(Vec3d(gradient_voxel)));
    return scene::shade<float>(view_.frame.lighting, color, gradient_world,
                               steep / (steep + view_.frame.soft_gradient), to_eye_, view_.frame.to_light);
  }

  const PassView<Voxel, N, M>& view_;
  Ray ray_;             // in tree space; t is the distance in the world
  Vec3f to_eye_;        // in the world
  RayInterval inside_;  // of the visible volume
};

}  // namespace gvx::render
