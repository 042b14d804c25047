#include "gvx/render/reference/joint_march.h"

#include <algorithm>

#include "gvx/render/reference/depth.h"
#include "gvx/render/reference/stretch.h"

namespace gvx::render {

/// Brings the objects' steps to distance t. False where one lacks data; the others ask all the same.
bool JointMarch::look(double t, PreviewPixel* preview, RayState& state) {
  bool all = true;
  for (std::size_t i = 0; i < segment_.size(); ++i) {
    if (t < segment_[i].enter || t < steps_[i].end) continue;
    all = objects_[segment_[i].object]->look(t, 1 - state.opacity, preview, steps_[i]) && all;
    state.samples += steps_[i].samples;
  }
  return all;
}

JointMarch::Sum JointMarch::sum_at(double t) const {
  Sum sum;
  for (std::size_t i = 0; i < segment_.size(); ++i) {
    const RaySpan& span = segment_[i];
    const ObjectStep& step = steps_[i];
    if (t < span.enter) {
      sum.end = std::min(sum.end, span.enter);
    } else if (step.surface < FrameView::kNever) {
      const double surface = std::max(step.surface, t);
      sum.end = std::min(sum.end, surface);
      if (surface < sum.surface)
        sum.surface = surface, sum.surface_color = step.color, sum.surface_of = &span;
    } else {
      sum.end = std::min(sum.end, step.end);
      sum.color = sum.color + step.extinction * Vec3d(step.color);
      sum.extinction += step.extinction;
      if (step.extinction > sum.most) sum.most = step.extinction, sum.densest = &span;
    }
  }
  return sum;
}

bool JointMarch::march(RayState& state, PreviewPixel* preview, RayReach* reach) {
  double t = std::max(state.tick, segment_[0].enter);
  while (state.phase == RayPhase::under_way) {
    if (!look(t, preview, state)) {
      state.tick = t;
      return false;
    }
    const Sum sum = sum_at(t);
    if (sum.end == FrameView::kNever) return true;
    const double length = sum.end - t;
    if (sum.extinction > 0) {
      const float before = state.opacity;
      add(state, Vec3f(sum.color / sum.extinction), opacity_of(static_cast<float>(sum.extinction * length)));
      if (reach != nullptr && state.opacity >= reach->opacity) {
        reach->distance = t + share_to(before, state.opacity, reach->opacity) * length;
        reach->object = static_cast<std::int32_t>(sum.densest->object);
        return true;
      }
    }
    if (sum.surface == sum.end && state.phase == RayPhase::under_way) {
      add(state, sum.surface_color, 1);
      if (reach != nullptr)
        *reach = {reach->opacity, sum.end, static_cast<std::int32_t>(sum.surface_of->object)};
      return true;
    }
    t = sum.end;
  }
  return true;
}

}  // namespace gvx::render
