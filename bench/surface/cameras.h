// The views of a model that the bench of surfaces measures.
#pragma once

#include "gvx/scene/camera.h"
#include "models.h"

namespace gvx::bench {

/// The model fills the picture, in height or width, whichever is tighter.
scene::Camera camera_that_fits(const Model& model, double aspect);
/// Twice as far from its target.
scene::Camera camera_far(const scene::Camera& fits);
/// Four times nearer to a place of the surface, which it looks at.
scene::Camera camera_near(const scene::Camera& fits, Vec3d place);
/// The same distance, along the surface: 8 degrees above it, from where fewest of it is between.
scene::Camera camera_grazing(const scene::Camera& fits, Vec3d place, const Model& model);

}  // namespace gvx::bench
