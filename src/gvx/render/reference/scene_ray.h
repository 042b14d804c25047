/// \file
/// SceneRay: the march of one ray through a scene of several objects, segment by segment. RayState::segment
/// is the first span of the segment that it is in, and RayState::tick counts there: in an object by itself
/// its ticks, in several at once it is the distance from the eye (joint_march.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gvx/render/reference/object_march.h"
#include "gvx/render/reference/ray_segments.h"

namespace gvx::render {

/// A ray and the objects on its way. `spans` are sorted; objects[spans[i].object] is the march of span i.
struct RayThroughObjects {
  BundleRay ray;
  std::span<const RaySpan> spans;
  std::span<const std::unique_ptr<ObjectMarch>> objects;
  /// Where objects project: how far they are, and as many samples as there can be in a segment.
  RayProjection* projection = nullptr;
  std::span<ProjectedSample> samples = {};
};

/// Marches a ray that is under way through its segment, and puts it before the next. False where it lacks
/// data, which it has then asked for. `preview` and `reach` as JointMarch has them.
bool march_segment(const RayThroughObjects& ray, RayState& state, PreviewPixel* preview = nullptr,
                   RayReach* reach = nullptr);

/// A ray is through its segment, behind which span `next` of so many begins.
void enter_segment(RayState& state, std::size_t next, std::size_t spans);

/// A ray of a scene by itself, for previews.
class SceneRay {
 public:
  SceneRay(const Pass& pass, double x, double y);

  /// Draws the whole ray with what is resident.
  PreviewPixel preview() const;
  /// Where a preview of the ray comes to this opacity.
  RayReach reach(float opacity) const;

 private:
  RayState march(PreviewPixel& pixel, RayReach* reach) const;

  BundleRay ray_;
  std::vector<RaySpan> spans_;
  std::vector<std::int32_t> objects_;  // of each march, as RayReach has them
  std::vector<std::unique_ptr<ObjectMarch>> marches_;
};

}  // namespace gvx::render
