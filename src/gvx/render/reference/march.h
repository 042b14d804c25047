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

#include "gvx/render/frame/frame.h"
#include "gvx/render/frame/ray_state.h"
#include "gvx/render/reference/depth.h"
#include "gvx/render/reference/gather.h"
#include "gvx/render/reference/object_ray.h"
#include "gvx/render/reference/stretch.h"
#include "gvx/render/reference/tree_walk.h"

namespace gvx::render {

template <typename Voxel, int N, int M>
class RayMarcher {
 public:
  GVX_HD RayMarcher(const PassView<Voxel, N, M>& view, const BundleRay& ray)
      : view_(view), walk_(view), ray_(view.frame, ray), inside_(ray_.inside) {
    for (int axis = 0; axis < 3; ++axis) inverse_direction_[axis] = 1 / ray_.tree.direction[axis];
  }

  /// Goes on until the ray is finished or lacks data, which it then asks for.
  GVX_HD void march_exact(RayState& state) const {
    Stretch<Voxel, M> stretch;
    while (next_stretch(state, stretch)) gather_stretch(ray_view(), stretch, state);
  }

  /// Leaps to the ray's next stretch within a brick and puts the state behind it: what is seen there is still
  /// to be gathered. False where the ray is finished or lacks data, which it then asks for.
  GVX_HD bool next_stretch(RayState& state, Stretch<Voxel, M>& stretch) const {
    while (state.phase == RayPhase::under_way) {
      Step step;
      if (!next_step(state, step)) return false;
      const Place place = descend(step, state);
      if (place.lacks()) {
        walk_.ask(place, 1 - state.opacity);
        return false;
      }
      if (take(state, step, place, stretch)) return true;
    }
    return false;
  }

  const Ray& ray_world() const { return ray_.world; }

  /// Draws the whole ray, or the rest of it, with what is resident; asks for what would have been better,
  /// coarse levels first. Counts in `pixel` what that wanted.
  GVX_HD void march_preview(RayState& state, PreviewPixel& pixel) const {
    Stretch<Voxel, M> stretch;
    for (Passed passed; (passed = pass_shown(state, stretch, pixel)) != Passed::nothing;) {
      if (passed == Passed::stretch) gather_stretch(ray_view(), stretch, state);
    }
  }

  /// As march_exact and, with `preview`, march_preview, for a projection; puts into `found` the distance from
  /// the eye at which the value is: of means the middle of the ray, of several channels where the last of
  /// them changed.
  GVX_HD void march_projection(RayState& state, double& found, PreviewPixel* preview) const {
    Stretch<Voxel, M> stretch;
    Step step;
    while (state.phase == RayPhase::under_way && next_step(state, step)) {
      Place place = descend(step, state);
      if (preview != nullptr) {
        make_do(step, 1, place, *preview);
      } else if (place.lacks()) {
        return walk_.ask(place, 1);
      }
      const RayState before = state;
      if (take(state, step, place, stretch)) {
        gather_stretch(ray_view(), stretch, state);
        found = changed_in(ray_view(), stretch, before, state, found);
      } else if (is_other_projection(view_.frame, before, state)) {
        found = step.t_centre;
      }
    }
    if (view_.frame.visibility.mode == scene::Mode::mean) found = 0.5 * (inside_.enter + inside_.exit);
  }

  /// The distance from the eye at which a preview of the ray, or of its rest, comes to this opacity, or
  /// infinity. Of isosurfaces that is the surface; of what is composited it lies within a step as if that
  /// were of one matter. Not for projections.
  GVX_HD double march_to(float opacity, RayState& state) const {
    PreviewPixel ignored;
    Stretch<Voxel, M> stretch;
    while (true) {
      const double tick = state.tick > ray_.first_tick ? state.tick : ray_.first_tick;
      const float before = state.opacity;
      const Passed passed = pass_shown(state, stretch, ignored);
      if (passed == Passed::nothing) return INFINITY;
      if (passed == Passed::stretch) {
        const double t = distance_in(ray_view(), stretch, state, opacity);
        if (t < INFINITY) return t;
      } else if (state.opacity >= opacity) {
        return t_at(tick) + share_to(before, state.opacity, opacity) * (t_at(state.tick) - t_at(tick));
      }
    }
  }

 protected:
  /// What a ray went through: nothing more, since it is finished; a stretch, which is to be gathered yet; or
  /// what is transparent, constant or lacking.
  enum class Passed { nothing, stretch, rest };

  /// The next step of a ray and how far steps of its level go on.
  struct Step {
    int level;
    double tick, stride;
    double zone_end;  ///< the tick at which a coarser level takes over, or begins to be blended in
    bool blended;     ///< some of the next coarser level is seen
    double t_centre;
    Vec3d p;  ///< its centre in tree space, from the bundle's origin
  };

  /// Moves a preview's ray behind the next node.
  GVX_HD Passed pass_shown(RayState& state, Stretch<Voxel, M>& stretch, PreviewPixel& pixel) const {
    Step step;
    if (state.phase != RayPhase::under_way || !next_step(state, step)) return Passed::nothing;
    Place place = descend(step, state);
    make_do(step, 1 - state.opacity, place, pixel);
    return take(state, step, place, stretch) ? Passed::stretch : Passed::rest;
  }

  /// Counts what a preview wants at a place; asks for what lacks there, and lets what is resident stand in.
  GVX_HD void make_do(const Step& step, float gain, Place& place, PreviewPixel& pixel) const {
    const bool lacking = place.lacks();
    if (place.kind != Place::transparent) {
      ++pixel.wanted;
      pixel.resident += lacking ? 0 : 1;
    }
    if (!lacking) return;
    walk_.ask(place, gain);
    if (place.lack != 0) {
      const std::uint32_t lack = place.lack_of(step.level);
      pixel.worst_lack = lack > pixel.worst_lack ? lack : pixel.worst_lack;
    }
    walk_.ask_for_own(place);
    if (place.lack != 0) place = walk_.stand_in(place);
  }

  GVX_HD double t_at(double tick) const { return inside_.enter + tick * view_.frame.tick_world; }

  GVX_HD bool next_step(RayState& state, Step& step) const {
    const FrameView& frame = view_.frame;
    if (state.tick < ray_.first_tick) state.tick = ray_.first_tick;
    step.tick = state.tick;
    const FrameView::Zone zone = frame.zone_at(inside_.enter, step.tick);
    step.level = zone.level;
    step.blended = zone.blended;
    step.zone_end = zone.end;
    step.stride = frame.stride_of(step.level, step.blended);
    step.t_centre = t_at(step.tick + 0.5 * step.stride);
    // A projection has a value wherever there is volume, be it less than half a step of it.
    if (projects() && step.tick == 0 && !(step.t_centre < inside_.exit)) {
      step.t_centre = 0.5 * (inside_.enter + inside_.exit);
    }
    if (inside_.empty() || !(step.t_centre < inside_.exit)) {
      finish(state);
      return false;
    }
    step.p = ray_.tree.at(step.t_centre);
    return true;
  }

  GVX_HD RayView ray_view() const { return {view_.frame, ray_.world, -Vec3f(ray_.world.direction)}; }

  GVX_HD bool projects() const { return render::projects(view_.frame); }

  GVX_HD void finish(RayState& state) const {
    state.phase = RayPhase::finished;
    if (projects()) finish_projection(ray_view(), static_cast<float>(state.tick), state);
  }

  GVX_HD Place descend(const Step& step, RayState& state) const {
    const LevelView& level = view_.frame.bundle.levels[step.level];
    Vec3d cell;
    for (int axis = 0; axis < 3; ++axis) cell[axis] = level.cell_at(axis, step.p[axis]);
    return walk_.to(step.level, step.blended, cell,
                    [&](NodeIndex node) { return outdone(view_.frame, view_.nodes, node, state); });
  }

  /// How many steps of this length have their centres in a place's node, of which one is at `t_centre`.
  GVX_HD double steps_in(const Place& place, double t_centre, double t_step) const {
    const LevelView& level = view_.frame.bundle.levels[place.level];
    double t_exit = inside_.exit;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = ray_.tree.direction[axis];
      if (d == 0) continue;
      const double face = level.face(axis, place.cell[axis] + (d > 0 ? 1 : 0));
      const double t = (face - ray_.tree.origin[axis]) * inverse_direction_[axis];
      t_exit = t < t_exit ? t : t_exit;
    }
    constexpr double kMostSteps = 1e15;
    const double count = (t_exit - t_centre) / t_step;
    return std::ceil(count > 1 ? (count < kMostSteps ? count : kMostSteps) : 1);
  }

  /// Moves the ray behind all steps whose centres are in the node. True where they are in a brick: then
  /// `stretch` is yet to be gathered.
  GVX_HD bool take(RayState& state, const Step& step, const Place& place, Stretch<Voxel, M>& stretch) const {
    // A preview's coarser brick is sampled in its own, longer steps.
    const bool coarser = place.coarser_than(step.level);
    const int step_level = coarser ? place.brick_level : step.level;
    const double stride = coarser ? view_.frame.stride[step_level] : step.stride;
    const double t_step = view_.frame.tick_world * stride;
    double whole = steps_in(place, step.t_centre, t_step);
    if (!coarser) {
      const double to_zone_end = std::rint((step.zone_end - step.tick) / stride);  // both are multiples of it
      whole = whole < to_zone_end ? whole : to_zone_end;
    }
    auto steps = static_cast<std::int64_t>(whole);

    // Steps within a stretch are counted in floats.
    constexpr std::int64_t kMostInBrick = 1 << 22;
    if (place.kind == Place::brick) steps = steps < kMostInBrick ? steps : kMostInBrick;
    state.tick += static_cast<double>(steps) * stride;
    if (place.kind == Place::constant) {
      gather_constant(ray_view(), walk_.ranges_of(place), stride, steps, state);
    }
    if (place.kind != Place::brick) return false;
    walk_.touch_bricks(place);
    stretch = stretch_of(step, place, step_level, stride, steps);
    return true;
  }

  /// The path of the steps' centres through a brick of `level` that holds the node.
  GVX_HD BrickPath<Voxel, M> path_in(BrickIndex slot, int level, const Step& step, const Place& place,
                                     double t_step) const {
    const BrickCorner<N> at(view_.frame, place, level);
    BrickPath<Voxel, M> path;
    path.brick = view_.bricks.brick(slot);
    path.voxels_across = static_cast<float>(at.across * M);
    for (int axis = 0; axis < 3; ++axis) {
      path.first[axis] = static_cast<float>((step.p[axis] - at.corner[axis]) * at.across * M);
      path.per_step[axis] = static_cast<float>(ray_.tree.direction[axis] * t_step * at.across * M);
    }
    return path;
  }

  GVX_HD Stretch<Voxel, M> stretch_of(const Step& step, const Place& place, int step_level, double stride,
                                      std::int64_t steps) const {
    const double t_step = view_.frame.tick_world * stride;
    Stretch<Voxel, M> s;
    s.steps = steps;
    s.level = step_level;
    s.stride = stride;
    s.t_centre = step.t_centre;
    s.t_step = t_step;
    s.fine = path_in(place.slot, place.brick_level, step, place, t_step);
    s.fine_deviates = place.deviates(view_.frame, step.level);
    if (projects()) s.ranges = walk_.ranges_of(place);
    s.blended = place.blended;
    if (view_.frame.adds_noise) {
      s.noisy = &view_.frame;
      s.place = view_.frame.bundle.origin + step.p;
      s.place_step = t_step * ray_.tree.direction;
    }
    if (s.blended) s.coarse = path_in(place.parent_slot, place.level - 1, step, place, t_step);
    return s;
  }

  const PassView<Voxel, N, M>& view_;
  TreeWalk<N> walk_;
  ObjectRay ray_;
  RayInterval inside_;       // the ray's
  Vec3d inverse_direction_;  // infinite where a direction is 0
};

}  // namespace gvx::render
