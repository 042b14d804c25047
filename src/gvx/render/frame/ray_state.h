/// \file
/// RayState: how far a ray has come and what it has gathered. An exact ray that lacks data keeps its state
/// and goes on from there in the next pass (2008 report: interrupt and resume).
#pragma once

#include <cstdint>

#include "gvx/core/vec.h"

namespace gvx::render {

enum class RayPhase : std::uint32_t { under_way = 0, finished = 1 };

/// 40 bytes. A state of another epoch than the film's is a ray that has not begun: clearing a film costs
/// nothing.
struct RayState {
  double tick = 0;    ///< where the next step starts
  Vec3f color;        ///< gathered so far, multiplied by its opacity
  float opacity = 0;  ///< 1 - transmittance
  RayPhase phase = RayPhase::under_way;
  std::uint32_t samples = 0;
  std::uint32_t epoch = 0;
  std::uint32_t segment = 0;  ///< of several objects: scene_ray.h
};

/// A pixel of the preview that stands in for a ray that is under way.
struct PreviewPixel {
  Vec3f color;  ///< multiplied by its opacity
  float opacity = 0;
  std::uint32_t wanted = 0;      ///< stretches of the ray that wanted data
  std::uint32_t resident = 0;    ///< of these, those that had it at the level wanted
  std::uint32_t worst_lack = 0;  ///< the most levels between one wanted and the one shown
  std::uint32_t epoch = 0;       ///< of the film when it was drawn; of another: not drawn
  std::uint32_t generation = 0;  ///< of the preview when it was drawn; of another: to be drawn again

  /// Of a ray that was drawn in parts: adds what another part wanted.
  void add_counts(const PreviewPixel& part) {
    wanted += part.wanted;
    resident += part.resident;
    worst_lack = worst_lack > part.worst_lack ? worst_lack : part.worst_lack;
  }
};

}  // namespace gvx::render
