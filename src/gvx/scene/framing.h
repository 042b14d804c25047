/// \file
/// Framing: from where a scene is looked at, and from how far, where a camera does not say.
#pragma once

#include <cstdint>

#include "gvx/core/affine.h"
#include "gvx/core/ray.h"
#include "gvx/core/up_axis.h"
#include "gvx/core/vec.h"
#include "gvx/scene/camera.h"
#include "gvx/scene/camera_parts.h"

namespace gvx::scene {

/// Which way a scene stands in the world, and so where its front is.
enum class Stance : std::uint32_t {
  z_up,    ///< the front faces -y: drawings, printing, maps
  y_up,    ///< the front faces +z, as glTF 2.0 (3.4, Coordinate System and Units) says
  patient  ///< x to the patient's right, y to the front, z up: the front is the face, at +y
};

Stance stance_of(UpAxis up, bool anatomical);

/// Where the viewer is: `to_eye` goes from the scene to the eye. Both are unit vectors.
struct Outlook {
  Vec3d to_eye, up;
};

/// Straight from a side. Left and right are at -x and +x: those of a viewer in front, but the patient's own.
/// From the top and the bottom the picture's right is +x, but from below a patient, where it is the patient's
/// left, as radiologists are used to.
Outlook outlook(Stance stance, Side side);

/// From the front, a little above and a little from the side: with y up from +x, since models that do not
/// face +z mostly face +x, else from -x.
Outlook standard_outlook(Stance stance);

/// What a camera frames.
struct Framing {
  Box3d box;  ///< what can be seen
  Affine3 box_to_world;
  Stance stance = Stance::z_up;
  double aspect = 1;  ///< the picture's width over its height
  double fill = 0.8;  ///< of the picture's width or height, whichever is tighter, that the box takes
};

/// The camera of which `given` are parts; the others frame the box: it takes `fill` of the picture in the
/// tighter direction, and no corner is nearer to the picture's edge than a quarter of what is left beside it.
/// - Without a view or an eye the box is seen from standard_outlook(), which is turned so that its up becomes
///   the one that is given.
/// - Without a target the eye looks at the box's centre, or at the origin that is given.
/// - With an eye that is given, the field of view is 30 degrees unless it is given, too.
/// The result may be no view, where `given` spans none.
Camera complete_camera(const CameraParts& given, const Framing& framing);

/// frame_box() of camera.h with another `fill`.
Camera frame_box(const Box3d& box, const Affine3& box_to_world, bool anatomical, double aspect, double fill);

}  // namespace gvx::scene
