/// \file
/// RayProjection: how far a ray has come through the objects of its segment that show a greatest, least or
/// mean value (reference/scene_ray.h). Films of scenes with such objects hold one for each ray.
#pragma once

#include <cstdint>

#include "gvx/core/vec.h"
#include "gvx/exec/buffer.h"
#include "gvx/render/frame/ray_state.h"

namespace gvx::render {

/// What a projection shows: one sample, where the value was found.
struct ProjectedSample {
  Vec3f color;  ///< multiplied by its opacity
  float opacity = 0;
  double distance = 0;  ///< from the eye
};

struct RayProjection {
  RayState gathering = {};  ///< of the object that is projected now
  double found = 0;         ///< at what distance its value was found
  std::uint32_t done = 0;   ///< objects of the segment, whose samples are known
  std::uint32_t epoch = 0;  ///< of the film; of another: the ray has not begun
};

/// Those of a film. Sample i of a ray is samples[ray * objects + i].
struct ProjectionsView {
  exec::BufferView<RayProjection> rays;
  exec::BufferView<ProjectedSample> samples;
  std::uint32_t objects = 0;  ///< that project in the scene
};

/// So many objects of a scene may project.
inline constexpr std::uint32_t kMostProjecting = 16;

}  // namespace gvx::render
