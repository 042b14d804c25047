/// \file
/// ObjectMarch: the march of one ray at a time through one object of a scene, whatever its voxels, N and M
/// are. On a CPU.
#pragma once

#include <cstdint>
#include <memory>

#include "gvx/core/vec.h"
#include "gvx/render/frame/frame.h"
#include "gvx/render/frame/ray_state.h"
#include "gvx/render/march_pass.h"

namespace gvx::render {

/// What a ray meets of an object from a distance on: matter of one colour, and at its end perhaps a surface.
struct ObjectStep {
  double end = FrameView::kNever;  ///< to this distance from the eye; kNever behind the object
  double extinction = 0;           ///< a unit of the world
  Vec3f color = {};
  double surface = FrameView::kNever;  ///< where an opaque surface of that colour is, instead of matter
  std::uint32_t samples = 0;           ///< that were taken to know it
};

class ObjectMarch {
 public:
  virtual ~ObjectMarch() = default;

  /// From now on it is this ray of the frame's bundle that marches.
  virtual void begin(const BundleRay& ray) = 0;

  /// Does it show a greatest, least or mean value?
  virtual bool projects() const = 0;

  /// As RayMarcher's.
  virtual void march_exact(RayState& state) const = 0;
  virtual void march_preview(RayState& state, PreviewPixel& pixel) const = 0;
  virtual void march_projection(RayState& state, double& found, PreviewPixel* preview) const = 0;
  virtual double march_to(float opacity, RayState& state) const = 0;
  /// As StepCursor's.
  virtual bool look(double t, float gain, PreviewPixel* preview, ObjectStep& shown) = 0;
};

/// That of an object in the pass of this number.
std::unique_ptr<ObjectMarch> march_of(const ObjectView& object, std::uint32_t pass);

}  // namespace gvx::render
