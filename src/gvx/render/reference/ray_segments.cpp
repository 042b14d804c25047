#include "gvx/render/reference/ray_segments.h"

#include <algorithm>
#include <tuple>

namespace gvx::render {

// Objects that touch do not overlap, whatever rounding does to their faces.
RaySpan::RaySpan(const FrameView& frame, const ObjectRay& ray, std::uint32_t object_)
    : enter(ray.inside.enter + ray.first_tick * frame.tick_world),
      overlap_end(ray.inside.exit - 0.5 * frame.tick_world),
      object(object_) {}

void sort_spans(std::span<RaySpan> spans) {
  std::sort(spans.begin(), spans.end(), [](const RaySpan& a, const RaySpan& b) {
    return std::tie(a.enter, a.object) < std::tie(b.enter, b.object);
  });
}

std::size_t segment_end(std::span<const RaySpan> spans, std::size_t first) {
  double end = spans[first].overlap_end;
  std::size_t next = first + 1;
  for (; next < spans.size() && spans[next].enter < end; ++next) {
    end = std::max(end, spans[next].overlap_end);
  }
  return next;
}

}  // namespace gvx::render
