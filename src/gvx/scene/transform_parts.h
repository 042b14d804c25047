/// \file
/// TransformParts: where a scene's object stands in the world, as it is written.
#pragma once

#include <optional>

#include "gvx/core/affine.h"
#include "gvx/core/vec.h"

namespace gvx::scene {

/// A turn about an axis through 0, counter-clockwise for who looks against the axis.
struct Rotation {
  Vec3d axis{0, 0, 1};  ///< of any length but 0
  double degrees = 0;

  bool operator==(const Rotation&) const = default;
};

/// A matrix; or a scale, then a rotation, then a translation. Nothing set: the object stays where it is.
struct TransformParts {
  std::optional<Affine3> matrix;  ///< in place of the others
  std::optional<Vec3d> translate;
  std::optional<Rotation> rotate;
  std::optional<Vec3d> scale;  ///< of each axis; negative ones mirror

  /// From the world of the object's volume to that of the scene.
  Affine3 to_world() const;
  bool operator==(const TransformParts&) const = default;
};

}  // namespace gvx::scene
