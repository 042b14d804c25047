/// \file
/// CameraParts: those parts of a camera that a scene file or a command line states. The program chooses the
/// others.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gvx/core/double_double.h"
#include "gvx/core/result.h"
#include "gvx/core/vec.h"
#include "gvx/scene/camera.h"

namespace gvx::scene {

/// The side from which a scene is seen. framing.h says where it is.
enum class Side : std::uint32_t { front, back, left, right, top, bottom };

/// The names of Side, in its order.
inline constexpr const char* kSideNames[] = {"front", "back", "left", "right", "top", "bottom"};

/// A camera with only some parts stated.
struct CameraParts {
  std::optional<Vec3dd> origin;  ///< also the target, if there is none
  std::optional<Vec3d> eye, target, up;
  std::optional<double> fov_degrees, height_world;  ///< at most one of them and of fit_height
  bool fit_height = false;                          ///< orthographic, with the height that the scene needs
  std::optional<Side> view;                         ///< in place of `eye`

  CameraParts() = default;
  /// All parts of `camera`.
  explicit CameraParts(const Camera& camera);
  /// `base` with the stated parts in place of its own. view and fit_height are ignored.
  Camera over(const Camera& base) const;
  /// `under` with the stated parts in place of its own. A view also replaces an eye, and an eye a view.
  CameraParts laid_over(const CameraParts& under) const;
  bool operator==(const CameraParts&) const = default;
};

/// The camera with a usable up, for an up that the user did not state. If it points along the view, it
/// becomes y; or z, if the view is along y.
Camera with_fitting_up(Camera camera);

/// Reads what to_text() writes. Parts may be left out, and height may be "fit".
Result<CameraParts> parse_camera_parts(const std::string& text);

}  // namespace gvx::scene
