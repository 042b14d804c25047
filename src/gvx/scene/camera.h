/// \file
/// Camera: a position and a direction of view in world space. CameraView: the ray of each pixel.
#pragma once

#include <cstdint>
#include <string>

#include "gvx/core/affine.h"
#include "gvx/core/double_double.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"

namespace gvx::scene {

/// A perspective camera. With height_world > 0 an orthographic one.
struct Camera {
  Vec3d eye{0, 0, 1};
  Vec3d target;
  Vec3d up{0, 1, 0};
  double fov_degrees = 30;  ///< vertical angle of view of a perspective camera
  double height_world = 0;  ///< height of an orthographic camera's picture
  /// The point to which eye and target are relative. It has more digits than a double, for views deep in a
  /// fractal.
  Vec3dd origin = {};

  bool orthographic() const { return height_world > 0; }
  /// Makes `to` the origin and the target. The eye stays where it is.
  void move_origin(Vec3dd to) {
    eye = Vec3d(eye_world() - to);
    target = {};
    origin = to;
  }
  Vec3dd eye_world() const { return origin + Vec3dd(eye); }
  constexpr bool operator==(const Camera&) const = default;
};

/// What kernels need to make rays. Directions are unit vectors, so t along a ray is a distance in the world.
struct CameraView {
  Vec3d eye;
  Vec3d forward, right, up;  ///< unit and orthogonal
  double pixel = 0;          ///< width of a pixel, at distance 1 (perspective) or anywhere (orthographic)
  double half_width = 0, half_height = 0;  ///< of the picture, in pixels
  bool orthographic = false;

  /// Each ray is as wide as a pixel.
  ConeShape cones() const { return orthographic ? ConeShape{pixel, 0} : ConeShape{0, pixel}; }
  /// The ray through the centre of pixel (x, y), (0, 0) at the upper left.
  GVX_HD Ray pixel_ray(double x, double y) const {
    const Ray ray = pixel_ray_from_eye(x, y);
    return {eye + ray.origin, ray.direction};
  }
  /// The same ray; its origin is relative to the eye.
  GVX_HD Ray pixel_ray_from_eye(double x, double y) const {
    const Vec3d across = (x + 0.5 - half_width) * pixel * right + (half_height - y - 0.5) * pixel * up;
    if (orthographic) return {across, forward};
    const Vec3d way = forward + across;
    // One division, as tile_rays_simd.cpp has it.
    return {{}, 1 / length(way) * way};
  }
};

/// An error if eye, target and up define no view, an angle is out of range, or there are no pixels.
Result<CameraView> make_view(const Camera& camera, std::uint32_t width, std::uint32_t height);

/// The text that parse_camera() reads: "eye=x,y,z;target=x,y,z;up=x,y,z;fov=degrees", to full precision. An
/// orthographic camera has "height=world" in place of "fov". An origin that is not 0 comes first, as
/// "origin=x,y,z;".
std::string to_text(const Camera& camera);

/// Reads what to_text() writes. Parts that are left out are those of `defaults`. If the default up points
/// along the view, another one is chosen (camera_parts.h). With an origin and no target, the origin is the
/// target.
Result<Camera> parse_camera(const std::string& text, const Camera& defaults);

/// A camera that shows the whole box `extent`, from a little to one side and above. A patient (anatomical: x
/// to the right, y to the front, z up) is seen from the front.
Camera frame_box(const Box3d& extent, const Affine3& extent_to_world, bool anatomical, double aspect);

}  // namespace gvx::scene
