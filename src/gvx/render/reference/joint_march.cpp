#include "gvx/render/reference/joint_march.h"

#include <algorithm>
#include <cmath>

#include "gvx/render/reference/depth.h"
#include "gvx/render/reference/stretch.h"

namespace gvx::render {

JointMarch::JointMarch(std::span<const RaySpan> segment,
                       std::span<const std::unique_ptr<ObjectMarch>> objects,
                       std::span<const ProjectedSample> samples)
    : segment_(segment), objects_(objects), steps_(segment.size(), ObjectStep{.end = 0}) {
  const double first = std::nextafter(segment[0].enter, FrameView::kNever);
  for (std::size_t i = 0; i < segment.size(); ++i) {
    if (!objects[segment[i].object]->projects()) continue;
    steps_[i].end = FrameView::kNever;
    samples_.push_back({samples[samples_.size()], &segment[i]});
    samples_.back().shown.distance = std::max(samples_.back().shown.distance, first);
  }
  std::stable_sort(samples_.begin(), samples_.end(),
                   [](const Sample& a, const Sample& b) { return a.shown.distance < b.shown.distance; });
}

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
  const auto next = std::find_if(samples_.begin(), samples_.end(),
                                 [&](const Sample& sample) { return sample.shown.distance > t; });
  if (next != samples_.end()) sum.end = std::min(sum.end, next->shown.distance);
  return sum;
}

/// Adds what one object shows at a distance, or on a way that ends there.
void JointMarch::add_seen(const Seen& seen, RayState& state, RayReach* reach) const {
  const float before = state.opacity;
  add(state, seen.color, seen.opacity);
  if (reach == nullptr || reach->object >= 0 || state.opacity < reach->opacity) return;
  const double share = seen.length > 0 ? share_to(before, state.opacity, reach->opacity) : 1;
  reach->distance = seen.end + (share - 1) * seen.length;
  reach->object = static_cast<std::int32_t>(seen.span->object);
}

/// Adds what lies behind distance t up to the sum's end.
void JointMarch::add_sum(double t, const Sum& sum, RayState& state, RayReach* reach) const {
  if (sum.extinction > 0) {
    const double length = sum.end - t;
    add_seen({Vec3f(sum.color / sum.extinction), opacity_of(static_cast<float>(sum.extinction * length)),
              sum.end, length, sum.densest},
             state, reach);
  }
  for (const Sample& sample : samples_) {
    const ProjectedSample& shown = sample.shown;
    if (shown.distance != sum.end || !(shown.opacity > 0.0f)) continue;
    if (state.phase != RayPhase::under_way) return;
    add_seen({shown.color / shown.opacity, shown.opacity, sum.end, 0, sample.span}, state, reach);
  }
  if (sum.surface == sum.end && state.phase == RayPhase::under_way) {
    add_seen({sum.surface_color, 1, sum.end, 0, sum.surface_of}, state, reach);
  }
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
    add_sum(t, sum, state, reach);
    if (reach != nullptr && reach->object >= 0) return true;
    t = sum.end;
  }
  return true;
}

}  // namespace gvx::render
