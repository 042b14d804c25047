/// \file
/// JointMarch: the march of a ray through objects that overlap. It goes from the nearest end of any object's
/// step to the next; between these every object is matter of one colour. Their extinctions add up, and the
/// colour is their mean, weighted by extinction. An isosurface is an opaque sample where it lies,
/// a projection one of its own opacity where its value was found.
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
  /// Through the objects of one segment's spans, in each of which the ray has begun. `samples` are what
  /// projections among them show, in the order of the spans.
  JointMarch(std::span<const RaySpan> segment, std::span<const std::unique_ptr<ObjectMarch>> objects,
             std::span<const ProjectedSample> samples);

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
  /// A colour of this opacity, of matter on a way of this length or of a sample.
  struct Seen {
    Vec3f color;
    float opacity;
    double end, length;
    const RaySpan* span;
  };
  void add_seen(const Seen& seen, RayState& state, RayReach* reach) const;
  void add_sum(double t, const Sum& sum, RayState& state, RayReach* reach) const;

  std::span<const RaySpan> segment_;
  std::span<const std::unique_ptr<ObjectMarch>> objects_;
  std::vector<ObjectStep> steps_;  // of each span, that holds the present distance
  /// A projection's, behind the segment's begin.
  struct Sample {
    ProjectedSample shown;
    const RaySpan* span;
  };
  std::vector<Sample> samples_;  // the nearest first
};

}  // namespace gvx::render
