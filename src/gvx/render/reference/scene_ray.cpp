#include "gvx/render/reference/scene_ray.h"

#include <cmath>

#include "gvx/render/reference/joint_march.h"
#include "gvx/render/reference/stretch.h"

namespace gvx::render {
namespace {

/// Through one object, beside which there is no other.
bool march_alone(const ObjectMarch& object, const RaySpan& span, RayState& state, PreviewPixel* preview,
                 RayReach* reach) {
  if (reach != nullptr) {
    reach->distance = object.march_to(reach->opacity, state);
    if (reach->distance < INFINITY) reach->object = static_cast<std::int32_t>(span.object);
    return true;
  }
  if (preview != nullptr) {
    object.march_preview(state, *preview);
    return true;
  }
  object.march_exact(state);
  return state.phase == RayPhase::finished;
}

}  // namespace

void enter_segment(RayState& state, std::size_t next, std::size_t spans) {
  const bool ends = state.opacity >= kOpaque || next == spans;
  state.phase = ends ? RayPhase::finished : RayPhase::under_way;
  state.segment = static_cast<std::uint32_t>(next);
  state.tick = 0;
}

bool march_segment(const RayThroughObjects& ray, RayState& state, PreviewPixel* preview, RayReach* reach) {
  const std::size_t end = segment_end(ray.spans, state.segment);
  const std::span<const RaySpan> segment = ray.spans.subspan(state.segment, end - state.segment);
  for (const RaySpan& span : segment) ray.objects[span.object]->begin(ray.x, ray.y);
  const bool through = segment.size() == 1
                           ? march_alone(*ray.objects[segment[0].object], segment[0], state, preview, reach)
                           : JointMarch(segment, ray.objects).march(state, preview, reach);
  if (through) enter_segment(state, end, ray.spans.size());
  return through;
}

SceneRay::SceneRay(const Pass& pass, double x, double y) : x_(x), y_(y) {
  for (std::uint32_t i = 0; i < pass.objects.size(); ++i) {
    const ObjectView& object = pass.objects[i];
    const ObjectRay ray(object.frame, x, y);
    if (ray.inside.empty()) continue;
    spans_.emplace_back(object.frame, ray, static_cast<std::uint32_t>(marches_.size()));
    objects_.push_back(i);
    marches_.push_back(march_of(object, pass.number));
  }
  sort_spans(spans_);
}

void SceneRay::march_exact(RayState& state) const {
  if (spans_.empty()) state.phase = RayPhase::finished;
  while (state.phase == RayPhase::under_way && march_segment(ray(), state)) {
  }
}

PreviewPixel SceneRay::preview() const {
  PreviewPixel pixel;
  RayState state;
  while (state.phase == RayPhase::under_way && state.segment < spans_.size()) {
    march_segment(ray(), state, &pixel);
  }
  pixel.color = state.color;
  pixel.opacity = state.opacity;
  return pixel;
}

RayReach SceneRay::reach(float opacity) const {
  RayReach reach{opacity};
  PreviewPixel ignored;
  RayState state;
  while (reach.object < 0 && state.phase == RayPhase::under_way && state.segment < spans_.size()) {
    march_segment(ray(), state, &ignored, &reach);
  }
  if (reach.object >= 0)
    reach.object = static_cast<std::int32_t>(objects_[static_cast<std::size_t>(reach.object)]);
  return reach;
}

}  // namespace gvx::render
