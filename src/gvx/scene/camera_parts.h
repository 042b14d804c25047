/// \file
/// CameraParts: those parts of a camera that a scene file or a command line states. The program chooses the
/// others.
#pragma once

#include <optional>
#include <string>

#include "gvx/core/double_double.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/scene/camera.h"

namespace gvx::scene {

/// A camera of which some parts are given.
struct CameraParts {
  std::optional<Vec3dd> origin;  ///< also the target, where none is given
  std::optional<Vec3d> eye, target, up;
  std::optional<double> fov_degrees, height_world;  ///< at most one of them

  CameraParts() = default;
  /// All parts of it.
  explicit CameraParts(const Camera& camera);
  /// `base` with the parts that are there.
  Camera over(const Camera& base) const;
  bool operator==(const CameraParts&) const = default;
};

/// The camera with a usable up, for an up that the user did not state. If it points along the view, it
/// becomes y; or z, if the view is along y.
Camera with_fitting_up(Camera camera);

/// Reads what to_text writes; parts may be left out.
Result<CameraParts> parse_camera_parts(const std::string& text);

}  // namespace gvx::scene
