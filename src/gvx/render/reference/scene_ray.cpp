#include "gvx/render/reference/scene_ray.h"

#include <algorithm>
#include <cmath>

#include "gvx/render/reference/joint_march.h"
#include "gvx/render/reference/stretch.h"
#include "gvx/render/reference/surface_hit.h"

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

/// Finds what those objects of a segment show that project, one after the other. False where one lacks data.
bool project(const RayThroughObjects& ray, std::span<const RaySpan> segment, RayState& state,
             PreviewPixel* preview) {
  RayProjection& projection = *ray.projection;
  std::uint32_t number = 0;
  for (const RaySpan& span : segment) {
    const ObjectMarch& object = *ray.objects[span.object];
    if (!object.projects() || number++ < projection.done) continue;
    RayState& gathering = projection.gathering;
    object.march_projection(gathering, projection.found, preview);
    if (gathering.phase != RayPhase::finished) return false;
    ray.samples[projection.done++] = {gathering.color, gathering.opacity, projection.found};
    state.samples += gathering.samples;
    gathering = {};
  }
  return true;
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
  for (const RaySpan& span : segment) ray.objects[span.object]->begin(ray.ray);
  const bool projecting = std::any_of(segment.begin(), segment.end(), [&](const RaySpan& span) {
    return ray.objects[span.object]->projects();
  });
  if (projecting && !project(ray, segment, state, preview)) return false;
  const bool through = segment.size() == 1 && !projecting
                           ? march_alone(*ray.objects[segment[0].object], segment[0], state, preview, reach)
                           : JointMarch(segment, ray.objects, ray.samples).march(state, preview, reach);
  if (!through) return false;
  if (projecting) *ray.projection = {.epoch = ray.projection->epoch};
  enter_segment(state, end, ray.spans.size());
  return true;
}

SceneRay::SceneRay(const Pass& pass, double x, double y) : ray_(pass.film.ray(x, y)) {
  SurfaceHit surface;
  if (!pass.surfaces.empty()) surface.set(pass.film, pass.surfaces, x, y);
  for (std::uint32_t i = 0; i < pass.objects.size(); ++i) {
    const ObjectView& object = pass.objects[i];
    const ObjectRay ray(object.frame, ray_);
    if (ray.inside.empty()) continue;
    const RaySpan span(object.frame, ray, static_cast<std::uint32_t>(marches_.size()));
    if (span.enter >= surface.distance()) continue;
    spans_.push_back(span);
    objects_.push_back(static_cast<std::int32_t>(i));
    marches_.push_back(march_of(object, pass.number));
  }
  if (surface.seen()) {
    spans_.push_back(surface.span(static_cast<std::uint32_t>(marches_.size())));
    objects_.push_back(RayReach::kSurface);
    marches_.push_back(std::make_unique<SurfaceHit>(surface));
  }
  sort_spans(spans_);
}

RayState SceneRay::march(PreviewPixel& pixel, RayReach* reach) const {
  RayState state;
  RayProjection projection;
  std::vector<ProjectedSample> samples(spans_.size());
  const auto goes_on = [&] { return state.phase == RayPhase::under_way && state.segment < spans_.size(); };
  while (goes_on() && (reach == nullptr || reach->object < 0)) {
    march_segment({ray_, spans_, marches_, &projection, samples}, state, &pixel, reach);
  }
  return state;
}

PreviewPixel SceneRay::preview() const {
  PreviewPixel pixel;
  const RayState state = march(pixel, nullptr);
  pixel.color = state.color;
  pixel.opacity = state.opacity;
  return pixel;
}

RayReach SceneRay::reach(float opacity) const {
  RayReach reach{opacity};
  PreviewPixel ignored;
  march(ignored, &reach);
  if (reach.object >= 0) {
    reach.object = objects_[static_cast<std::size_t>(reach.object)];
  }
  return reach;
}

}  // namespace gvx::render
