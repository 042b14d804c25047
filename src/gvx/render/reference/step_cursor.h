/// \file
/// StepCursor: what a ray meets of an object at a given distance from the eye. Rays that are in several
/// objects at once ask each for its step there (joint_march.h).
///
/// What is found is a function of the distance alone: not of where the ray was before, nor of what was
/// resident then. The steps are those of march.h.
#pragma once

#include <cmath>
#include <cstdint>

#include "gvx/render/reference/march.h"
#include "gvx/render/reference/object_march.h"

namespace gvx::render {

template <typename Voxel, int N, int M>
class StepCursor : public RayMarcher<Voxel, N, M> {
  using March = RayMarcher<Voxel, N, M>;
  using typename March::Step;

 public:
  GVX_HD StepCursor(const PassView<Voxel, N, M>& view, const BundleRay& ray) : March(view, ray) {
    zone_ = view.frame.zone_at(this->inside_.enter, 0);
  }

  /// What the object shows at distance t, which must be no less than in the call before. `gain` is the ray's
  /// transmittance there. False where data lacks, which is then asked for; a preview makes do with what is
  /// resident and counts what it wanted. Not for projections.
  GVX_HD bool look(double t, float gain, PreviewPixel* preview, ObjectStep& shown) {
    shown = {};
    RayState at;
    at.tick = tick_at(t);
    Step step;
    if (!this->next_step(at, step)) return true;
    if (!(has_place_ && is_of_walk(step) && holds(step, 0)) && !walk(step, gain, preview)) return false;
    double steps = 1;
    if (place_.kind != Place::brick) {
      steps = steps_left(step);
    } else if (place_.coarser_than(step.level)) {
      widen(step);
    }
    const double length = this->view_.frame.tick_world * step.stride;
    shown.end = this->t_at(step.tick + steps * step.stride);
    // Where a step is less than doubles tell apart.
    if (!(shown.end > t)) shown.end = t + length;
    gather(step, length, shown);
    return true;
  }

 private:
  /// The tick of the step that holds distance t: zone by zone from the first, in whole steps.
  GVX_HD double tick_at(double t) {
    const FrameView& frame = this->view_.frame;
    while (this->t_at(zone_.end) <= t) {
      zone_begin_ = zone_.end;
      zone_ = frame.zone_at(this->inside_.enter, zone_begin_);
    }
    const double stride = frame.stride_of(zone_.level, zone_.blended);
    const auto tick = [&](double step) { return zone_begin_ + step * stride; };
    double step = std::floor((t - this->t_at(zone_begin_)) / (stride * frame.tick_world));
    // By as much as rounding may be wrong.
    constexpr int kMost = 4;
    step = step > 0 ? step : 0;
    for (int i = 0; i < kMost && step > 0 && this->t_at(tick(step)) > t; ++i) --step;
    for (int i = 0; i < kMost && this->t_at(tick(step + 1)) <= t; ++i) ++step;
    return tick(step);
  }

  /// Goes down to the node that holds a step's centre. False where that lacks data and no preview makes do.
  GVX_HD bool walk(const Step& step, float gain, PreviewPixel* preview) {
    RayState ignored;
    ignored.opacity = 1 - gain;
    has_place_ = false;
    place_ = this->descend(step, ignored);
    if (preview != nullptr) {
      this->make_do(step, gain, place_, *preview);
    } else if (place_.lacks()) {
      this->walk_.ask(place_, gain);
      return false;
    }
    if (place_.kind == Place::brick) this->walk_.touch_bricks(place_);
    has_place_ = true;
    walk_level_ = step.level;
    walk_blended_ = step.blended;
    first_ = last_ = place_.cell;
    for (int level = place_.level + 1; level <= step.level; ++level) {
      const Vec3d digit = this->view_.frame.bundle.levels[level].digit;
      first_ = double(N) * first_ - digit;
      last_ = double(N) * last_ - digit + Vec3d(N - 1);
    }
    return true;
  }

  GVX_HD bool is_of_walk(const Step& step) const {
    return step.level == walk_level_ && step.blended == walk_blended_;
  }
  /// Is the centre of the step that comes so many after this one in the place's node?
  GVX_HD bool holds(const Step& step, double later) const {
    const double t = this->t_at(step.tick + (later + 0.5) * step.stride);
    if (!(t < this->inside_.exit)) return false;
    const Vec3d p = this->ray_.tree.at(t);
    const LevelView& level = this->view_.frame.bundle.levels[step.level];
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = level.cell_at(axis, p[axis]);
      if (cell < first_[axis] || cell > last_[axis]) return false;
    }
    return true;
  }
  /// How many steps from this one on are in the place's node. Whichever of them is asked, they end at the
  /// same.
  GVX_HD double steps_left(const Step& step) const {
    const double most = std::rint((step.zone_end - step.tick) / step.stride);
    double steps = this->steps_in(place_, step.t_centre, this->view_.frame.tick_world * step.stride);
    steps = steps < most ? steps : most;
    while (steps > 1 && !holds(step, steps - 1)) --steps;
    while (steps < most && holds(step, steps)) ++steps;
    return steps;
  }
  /// A preview's coarser brick is sampled in longer steps.
  GVX_HD void widen(Step& step) const {
    const double own = this->view_.frame.stride[place_.brick_level] / step.stride, left = steps_left(step);
    step.stride *= own < left ? std::floor(own) : left;
    step.t_centre = this->t_at(step.tick + 0.5 * step.stride);
    step.p = this->ray_.tree.at(step.t_centre);
  }

  /// What one step of this length shows by itself.
  GVX_HD void gather(const Step& step, double length, ObjectStep& shown) const {
    const RayView ray = this->ray_view();
    RayState seen;
    if (place_.kind == Place::constant) {
      gather_constant(ray, this->walk_.ranges_of(place_), step.stride, 1, seen);
    } else if (place_.kind == Place::brick) {
      const int level = place_.coarser_than(step.level) ? place_.brick_level : step.level;
      const Stretch<Voxel, M> one = this->stretch_of(step, place_, level, step.stride, 1);
      gather_stretch(ray, one, seen);
      if (seen.opacity > 0.0f && finds_surfaces(ray.frame)) {
        const double surface = one.t_at(surface_in(ray, one));
        shown.surface = surface < shown.end ? surface : shown.end;
      }
    }
    shown.samples = seen.samples;
    if (!(seen.opacity > 0.0f)) return;
    // More counts as this: its extinction is a number.
    constexpr float kMost = 1 - 1e-6f;
    shown.color = seen.color / seen.opacity;
    shown.extinction = -std::log1p(-double(seen.opacity < kMost ? seen.opacity : kMost)) / length;
  }

  FrameView::Zone zone_;  // that holds the distance asked for last
  double zone_begin_ = 0;
  Place place_;  // that was walked to last, for steps of this level
  bool has_place_ = false;
  int walk_level_ = 0;
  bool walk_blended_ = false;
  Vec3d first_, last_;  // nodes of that level that are in the place's node
};

}  // namespace gvx::render
