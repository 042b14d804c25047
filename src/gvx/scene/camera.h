/// \file
/// Camera: where one looks from, in world space, and the ray of each pixel.
#pragma once

#include <cstdint>
#include <string>

#include "gvx/core/affine.h"
#include "gvx/core/double_double.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"

namespace gvx::scene {

/// A perspective camera, or an orthographic one where height_world > 0.
struct Camera {
  Vec3d eye{0, 0, 1};
  Vec3d target;
  Vec3d up{0, 1, 0};
  double fov_degrees = 30;  ///< vertical; of a perspective camera
  double height_world = 0;  ///< of the picture; of an orthographic camera
  /// What eye and target are told from: near a place that takes more digits than a double has.
  Vec3dd origin = {};

  bool orthographic() const { return height_world > 0; }
  /// Looks at this origin, from where it is.
  void move_origin(Vec3dd to) {
    eye = Vec3d(eye_world() - to);
    target = {};
    origin = to;
  }
  Vec3dd eye_world() const { return origin + Vec3dd(eye); }
  constexpr bool operator==(const Camera&) const = default;
};

/// What kernels make rays with: unit directions, so that t is a distance in the world.
struct CameraView {
  Vec3d eye;
  Vec3d forward, right, up;  ///< unit and orthogonal
  double pixel = 0;          ///< width of a pixel: at distance 1 (perspective) or everywhere (orthographic)
  double half_width = 0, half_height = 0;  ///< of the picture, in pixels
  bool orthographic = false;

  /// The ray through the centre of pixel (x, y), (0, 0) at the upper left.
  GVX_HD Ray pixel_ray(double x, double y) const {
    const Ray ray = pixel_ray_from_eye(x, y);
    return {eye + ray.origin, ray.direction};
  }
  /// The same ray; its origin is told from the eye.
  GVX_HD Ray pixel_ray_from_eye(double x, double y) const {
    const Vec3d across = (x + 0.5 - half_width) * pixel * right + (half_height - y - 0.5) * pixel * up;
    if (orthographic) return {across, forward};
    const Vec3d way = forward + across;
    // One division, as tile_rays_simd.cpp has it.
    return {{}, 1 / length(way) * way};
  }
};

/// An error where eye, target and up span no view, or an angle is out of range.
Result<CameraView> make_view(const Camera& camera, std::uint32_t width, std::uint32_t height);

/// The text that parse_camera takes: "eye=x,y,z;target=x,y,z;up=x,y,z;fov=degrees" (or height=world), to full
/// precision; with "origin=x,y,z;" before it where that is not 0.
std::string to_text(const Camera& camera);

/// Reads what to_text writes; parts may be left out and are those of `defaults`, but for an up that points
/// along the view (camera_parts.h). The target beside an origin is that origin if not given.
Result<Camera> parse_camera(const std::string& text, const Camera& defaults);

/// Frames the world-space image of the box `extent` from a little to one side and above; an anatomical volume
/// (x to the right, y to the front, z up) is seen in the face.
Camera frame_box(const Box3d& extent, const Affine3& extent_to_world, bool anatomical, double aspect);

}  // namespace gvx::scene
