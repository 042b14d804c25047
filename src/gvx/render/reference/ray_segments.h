/// \file
/// The segments of a ray: what of it is in which objects. Objects whose boxes it meets at the same time are
/// of one segment, and are marched jointly; an object beside which there is no other is marched by itself.
///
///     object 0    |------|
///     object 1                |----------|
///     object 2                       |----------|
///     segments    |--0---|    |-----1, 2--------|
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gvx/render/reference/object_ray.h"

namespace gvx::render {

/// What of a ray is in one object: distances from the eye.
struct RaySpan {
  double enter = 0;
  double overlap_end = 0;    ///< what begins before this, overlaps it
  std::uint32_t object = 0;  ///< its index among those that the ray's spans are of

  RaySpan(const FrameView& frame, const ObjectRay& ray, std::uint32_t object);
  RaySpan(double enter_, double overlap_end_, std::uint32_t object_)
      : enter(enter_), overlap_end(overlap_end_), object(object_) {}
};

/// Into the order in which a ray meets them.
void sort_spans(std::span<RaySpan> spans);

/// Of sorted spans, behind which the segment that begins with span `first` ends.
std::size_t segment_end(std::span<const RaySpan> spans, std::size_t first);

}  // namespace gvx::render
