/// \file
/// Cameras as other renderers have them: a view matrix and a projection matrix. They serve to show a volume
/// together with rasterised geometry. The camera is taken from the matrices, or the matrices from the camera,
/// and depths of gvx's picture become values of a depth buffer.
#pragma once

#include <array>
#include <limits>

#include "gvx/core/result.h"
#include "gvx/scene/camera.h"

namespace gvx::scene {

/// A matrix in the order in which OpenGL, Vulkan and GLM have it in memory, column after column: the number
/// in row i and column j is at [4 * j + i]. It stands to the left of a point.
using Matrix4 = std::array<double, 16>;

/// For matrices that are in memory row after row, or that stand to the right of a point.
Matrix4 transposed(const Matrix4& matrix);

/// What a projection's results mean, after the division by w. x is from -1 at the left to 1.
struct ClipSpace {
  double near_z = -1, far_z = 1;  ///< z of the near and of the far plane: -1 and 1, or 0 and 1, or reversed
  bool y_down = false;            ///< y is 1 at the bottom of the picture; otherwise -1

  /// OpenGL and WebGL, where glClipControl() was not called.
  static constexpr ClipSpace opengl() { return {-1, 1, false}; }
  /// Vulkan, with viewports of positive height.
  static constexpr ClipSpace vulkan() { return {0, 1, true}; }
  /// Direct3D, Metal and WebGPU.
  static constexpr ClipSpace direct3d() { return {0, 1, false}; }
  /// The same with z exchanged between near and far ("reversed z").
  constexpr ClipSpace reversed() const { return {far_z, near_z, y_down}; }
};

/// What matrices say besides a camera. Distances are from the eye, along the view.
struct Frustum {
  ClipSpace clip;
  double aspect = 1;      ///< the picture's width over its height
  double near_world = 0;  ///< above 0; of an orthographic camera it may be 0
  double far_world = std::numeric_limits<double>::infinity();  ///< of an orthographic camera it is finite
};

struct CameraAndFrustum {
  Camera camera;
  Frustum frustum;
};

struct CameraMatrices {
  Matrix4 view;        ///< from the world to the eye's space: the eye at 0, x right, y up, the view along -z
  Matrix4 projection;  ///< from the eye's space to clip space
};

/// The camera whose picture shows each point of the world where the matrices show it. The picture must have
/// the frustum's aspect. The eye's space may be right-handed or left-handed. The eye of an orthographic
/// camera is moved to the middle of the picture, and to the near plane where that is behind it. An error if
/// the matrices mirror or shear the picture, if the depth is not measured along the view, or if the view of a
/// perspective camera does not go through the picture's middle.
Result<CameraAndFrustum> camera_from_matrices(const Matrix4& view, const Matrix4& projection,
                                              const ClipSpace& clip);

/// The matrices that show each point of the world where the camera shows it. An error if the camera defines
/// no view, or the frustum's numbers are out of range.
Result<CameraMatrices> matrices_of(const Camera& camera, const Frustum& frustum);

/// What a depth buffer holds, from 0 to 1, for a depth of render::PictureTarget: a distance from the eye
/// along the view. Depths that are not between the planes have the value of the nearer plane; so an infinite
/// depth, where the picture shows nothing, lies on the far plane.
double depth_buffer_value(double depth_world, const Frustum& frustum, bool orthographic);

}  // namespace gvx::scene
