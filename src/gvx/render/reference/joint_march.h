/// \file
/// JointMarch: the march of a ray through objects that overlap. It goes from the nearest end of any object's
/// step to the next; between these every object is matter of one colour. Their extinctions add up, and the
/// colour is their mean, weighted by extinction. An isosurface is an opaque sample where it lies.
///
/// Its state is the distance from the eye alone, from which every object's step follows (step_cursor.h): so a
/// ray that lacks data goes on later with the same bits.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gvx/render/reference/object_march.h"
#include "gvx/render/reference/ray_segments.h"

namespace gvx::render {

class JointMarch {
 public:
  /// Through the objects of one segment's spans, in each of which the ray has begun.
  JointMarch(std::span<const RaySpan> segment, std::span<const std::unique_ptr<ObjectMarch>> objects)
      : segment_(segment), objects_(objects), steps_(segment.size(), ObjectStep{.end = 0}) {}

  /// Goes on from distance state.tick. False where the ray lacks data, which it has then asked for; otherwise
  /// it is behind the segment, or finished. `preview`, if not null, makes do with what is resident and counts
  /// what it wanted. `reach`, if not null, is told where the ray comes to its opacity: there the march ends.
  bool march(RayState& state, PreviewPixel* preview, RayReach* reach = nullptr);

 private:
  /// What all objects together show from a distance on.
  struct Sum {
    double end = FrameView::kNever;
    double extinction = 0, most = 0;
    Vec3d color;                       // multiplied by the extinction
    const RaySpan* densest = nullptr;  // has the most of it
    double surface = FrameView::kNever;
    Vec3f surface_color;
    const RaySpan* surface_of = nullptr;
  };
  bool look(double t, PreviewPixel* preview, RayState& state);
  Sum sum_at(double t) const;

  std::span<const RaySpan> segment_;
  std::span<const std::unique_ptr<ObjectMarch>> objects_;
  std::vector<ObjectStep> steps_;  // of each span, that holds the present distance
};

}  // namespace gvx::render
