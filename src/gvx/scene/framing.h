/// \file
/// Framing: chooses the direction and distance of a camera that does not state them.
#pragma once

#include <cstdint>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/ray.h"
#include "gvx/core/up_axis.h"
#include "gvx/core/vec.h"
#include "gvx/scene/camera.h"
#include "gvx/scene/camera_parts.h"

namespace gvx::scene {

/// Which way is up in a scene, and where its front is.
enum class Stance : std::uint32_t {
  z_up,    ///< the front faces -y: drawings, printing, maps
  y_up,    ///< the front faces +z, as glTF 2.0 (3.4, Coordinate System and Units) says
  patient  ///< x to the patient's right, y to the front, z up: the front is the face, at +y
};

Stance stance_of(UpAxis up, bool anatomical);

/// A direction of view: `to_eye` points from the scene to the eye. Both are unit vectors.
struct Outlook {
  Vec3d to_eye, up;
};

/// The view straight from a side. Left is at -x and right at +x. For a viewer in front these are left and
/// right; for patients they are their own. From the top and the bottom, the picture's right is +x. Patients
/// seen from below are an exception: the picture's right is their left, as in radiology.
Outlook outlook(Stance stance, Side side);

/// The view from the front, a little above and a little from the side. With y up it is from +x, since most
/// models that do not face +z face +x. Otherwise it is from -x.
Outlook standard_outlook(Stance stance);

/// What a camera shows.
struct Framing {
  Box3d box;  ///< the box of what is visible
  /// Points whose convex hull holds what is visible, in the box's space; empty: the box's corners.
  std::vector<Vec3d> points = {};
  Affine3 box_to_world;
  Stance stance = Stance::z_up;
  double aspect = 1;  ///< the picture's width over its height
  double fill = 0.8;  ///< the share of the picture's width or height, whichever is tighter, that it takes
};

/// A camera with the parts `given`. The other parts are chosen so that what is visible takes `fill` of the
/// picture in the tighter direction. No point of it is nearer to the picture's edge than a quarter of the
/// margin.
/// - Without a view or an eye: the camera looks from standard_outlook(). If an up is given, this is turned
/// with it.
/// - Without a target: the camera looks at the box's centre, or at the origin if one is given.
/// - With an eye: the field of view is 30 degrees, unless it is given.
/// If the given parts do not define a view, neither does the result.
Camera complete_camera(const CameraParts& given, const Framing& framing);

/// frame_box() of camera.h with another `fill`.
Camera frame_box(const Box3d& box, const Affine3& box_to_world, bool anatomical, double aspect, double fill);

}  // namespace gvx::scene
