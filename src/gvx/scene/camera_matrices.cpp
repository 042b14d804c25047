#include "gvx/scene/camera_matrices.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace gvx::scene {
namespace {

/// By how much unit vectors may be off: matrices of floats are, by less. A fiftieth of a pixel in a picture
/// 4000 pixels wide.
constexpr double kTolerance = 1e-5;

constexpr double kDegrees = 180 / std::numbers::pi;

Error bad_matrices(const std::string& what) {
  return Error{"camera matrices: " + what};
}

double at(const Matrix4& m, int row, int column) {
  return m[static_cast<std::size_t>(4 * column + row)];
}

Matrix4 product(const Matrix4& a, const Matrix4& b) {
  Matrix4 c{};
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      for (int k = 0; k < 4; ++k)
        c[static_cast<std::size_t>(4 * column + row)] += at(a, row, k) * at(b, k, column);
    }
  }
  return c;
}

Vec3d along(Vec3d v, Vec3d unit) {
  return dot(v, unit) * unit;
}

/// A row of a matrix: a linear function of a point.
struct Row {
  Vec3d linear;
  double constant = 0;

  static Row of(const Matrix4& m, int row, double scale) {
    return {scale * Vec3d(at(m, row, 0), at(m, row, 1), at(m, row, 2)), scale * at(m, row, 3)};
  }
  double operator()(Vec3d p) const { return dot(linear, p) + constant; }
};

/// Where the functions are 0.
Vec3d common_zero(const Row& a, const Row& b, const Row& c) {
  const Vec3d bc = cross(b.linear, c.linear), ca = cross(c.linear, a.linear), ab = cross(a.linear, b.linear);
  return -(a.constant * bc + b.constant * ca + c.constant * ab) / dot(a.linear, bc);
}

/// Matrices from the world to the clip space, taken apart.
struct Parts {
  Row x, y, z, w;  ///< of the clip space, y up, scaled so that w is a distance or 1
  bool orthographic = false;
  Vec3d forward, right, up;     ///< unit vectors
  double scale_x, scale_y = 0;  ///< of what is across the view, by which it becomes x and y

  /// Does the picture lie as that of a camera with these three axes would?
  Status check() const {
    if (!(scale_x > 0) || !(scale_y > 0) || !(length(forward) > 0))
      return bad_matrices("they have no inverse");
    if (std::abs(dot(right, up)) > kTolerance) return bad_matrices("the picture's axes are not orthogonal");
    if (dot(cross(forward, up), right) < 0) {
      return bad_matrices(
          "the picture is mirrored; does y point down where the clip space says up, or up where "
          "it says down?");
    }
    if (orthographic && std::max(std::abs(dot(right, forward)), std::abs(dot(up, forward))) > kTolerance) {
      return bad_matrices("the projection is oblique; expected planes of depth across the view");
    }
    if (orthographic) return {};
    if (std::max(std::abs(dot(x.linear, forward)), std::abs(dot(y.linear, forward))) > kTolerance) {
      return bad_matrices(
          "the view does not go through the middle of the picture; expected a frustum with "
          "left = -right and bottom = -top");
    }
    if (length(z.linear - along(z.linear, forward)) > kTolerance) {
      return bad_matrices("the near plane is oblique; expected one across the view");
    }
    return {};
  }
};

Result<Parts> take_apart(const Matrix4& view, const Matrix4& projection, const ClipSpace& clip) {
  const Matrix4 all = product(projection, view);
  for (const double number : all) {
    if (!std::isfinite(number)) return bad_matrices("a number is not finite");
  }
  if (at(view, 3, 0) != 0 || at(view, 3, 1) != 0 || at(view, 3, 2) != 0 || at(view, 3, 3) != 1) {
    return bad_matrices(
        "the last row of the view matrix is not 0 0 0 1; transposed() turns one that is in memory "
        "row after row");
  }
  Parts parts;
  const Row w = Row::of(all, 3, 1);
  parts.orthographic = length(w.linear) == 0;
  const double scale = 1 / (parts.orthographic ? w.constant : length(w.linear));
  if (!(scale > 0) || !std::isfinite(scale)) return bad_matrices("they have no inverse");
  parts.w = Row::of(all, 3, scale);
  parts.x = Row::of(all, 0, scale);
  parts.y = Row::of(all, 1, clip.y_down ? -scale : scale);
  parts.z = Row::of(all, 2, scale);
  const Vec3d deeper = clip.far_z > clip.near_z ? parts.z.linear : -parts.z.linear;
  parts.forward = parts.orthographic ? normalize(deeper) : parts.w.linear;
  const Vec3d ahead = parts.orthographic ? Vec3d() : parts.forward;
  const Vec3d across = parts.x.linear - along(parts.x.linear, ahead);
  const Vec3d upward = parts.y.linear - along(parts.y.linear, ahead);
  parts.scale_x = length(across);
  parts.scale_y = length(upward);
  parts.right = across / parts.scale_x;
  parts.up = upward / parts.scale_y;
  GVX_TRY(parts.check());
  return parts;
}

/// Of a linear function of the distance from the eye, along which z goes by `slope` from `start`.
void set_planes(double start, double slope, Frustum& frustum) {
  frustum.near_world = (frustum.clip.near_z - start) / slope;
  frustum.far_world = (frustum.clip.far_z - start) / slope;
}

CameraAndFrustum orthographic(const Parts& parts, const Matrix4& view, const ClipSpace& clip) {
  const Vec3d given = common_zero(Row::of(view, 0, 1), Row::of(view, 1, 1), Row::of(view, 2, 1));
  CameraAndFrustum made;
  made.frustum.clip = clip;
  Vec3d& eye = made.camera.eye;
  eye = given - parts.x(given) / parts.scale_x * parts.right - parts.y(given) / parts.scale_y * parts.up;
  set_planes(parts.z(eye), dot(parts.z.linear, parts.forward), made.frustum);
  if (made.frustum.near_world < 0) {
    eye = eye + made.frustum.near_world * parts.forward;
    made.frustum.far_world -= made.frustum.near_world;
    made.frustum.near_world = 0;
  }
  made.camera.height_world = 2 / parts.scale_y;
  return made;
}

CameraAndFrustum perspective(const Parts& parts, const ClipSpace& clip) {
  CameraAndFrustum made;
  made.frustum.clip = clip;
  made.camera.eye = common_zero(parts.x, parts.y, parts.w);
  made.camera.fov_degrees = 2 * std::atan(1 / parts.scale_y) * kDegrees;
  // z is limit + scale / distance.
  const double limit = dot(parts.z.linear, parts.forward), scale = parts.z(made.camera.eye);
  made.frustum.near_world = scale / (clip.near_z - limit);
  constexpr double kRounding = 1e-14;
  if (std::abs(clip.far_z - limit) > kRounding) made.frustum.far_world = scale / (clip.far_z - limit);
  return made;
}

Status check(const Frustum& frustum, bool orthographic) {
  const auto [near, far] = std::pair(frustum.near_world, frustum.far_world);
  if (!(frustum.aspect > 0) || !std::isfinite(frustum.aspect)) {
    return bad_matrices("aspect: expected the picture's width over its height, above 0");
  }
  const bool sound = orthographic ? near >= 0 && far > near && std::isfinite(far) : near > 0 && far > near;
  if (!sound) {
    return bad_matrices("near and far: " + std::to_string(near) + " and " + std::to_string(far) +
                        (orthographic ? "; expected 0 <= near < far" : "; expected 0 < near < far") +
                        ". Is the clip space the projection's?");
  }
  return {};
}

Matrix4 from_rows(const std::array<double, 16>& rows) {
  return transposed(rows);
}

Matrix4 view_matrix(const CameraView& v) {
  const Vec3d back = -v.forward;
  return from_rows({v.right.x, v.right.y, v.right.z, -dot(v.right, v.eye),  //
                    v.up.x, v.up.y, v.up.z, -dot(v.up, v.eye),              //
                    back.x, back.y, back.z, -dot(back, v.eye),              //
                    0, 0, 0, 1});
}

}  // namespace

Matrix4 transposed(const Matrix4& matrix) {
  Matrix4 turned;
  for (std::size_t i = 0; i < 16; ++i) turned[i] = matrix[4 * (i % 4) + i / 4];
  return turned;
}

Result<CameraAndFrustum> camera_from_matrices(const Matrix4& view, const Matrix4& projection,
                                              const ClipSpace& clip) {
  GVX_ASSIGN(const Parts parts, take_apart(view, projection, clip));
  CameraAndFrustum made = parts.orthographic ? orthographic(parts, view, clip) : perspective(parts, clip);
  made.frustum.aspect = parts.scale_y / parts.scale_x;
  GVX_TRY(check(made.frustum, parts.orthographic));
  Camera& camera = made.camera;
  // So far away that the direction keeps its digits.
  camera.target = camera.eye + std::max(1.0, length(camera.eye)) * parts.forward;
  camera.up = parts.up;
  GVX_ASSIGN(const CameraView sound, make_view(camera, 1, 1));
  (void)sound;
  return made;
}

Result<CameraMatrices> matrices_of(const Camera& camera, const Frustum& frustum) {
  GVX_ASSIGN(const CameraView view, make_view(camera, 1, 1));
  GVX_TRY(check(frustum, view.orthographic));
  const double up = 2 / view.pixel, right = up / frustum.aspect, down = frustum.clip.y_down ? -up : up;
  const double near_z = frustum.clip.near_z, far_z = frustum.clip.far_z;
  const double near = frustum.near_world, far = frustum.far_world;
  if (view.orthographic) {
    const double slope = (far_z - near_z) / (far - near);
    return CameraMatrices{view_matrix(view), from_rows({right, 0, 0, 0,                       //
                                                        0, down, 0, 0,                        //
                                                        0, 0, -slope, near_z - slope * near,  //
                                                        0, 0, 0, 1})};
  }
  const double scale = (near_z - far_z) / (1 / near - 1 / far), limit = far_z - scale / far;
  return CameraMatrices{view_matrix(view), from_rows({right, 0, 0, 0,       //
                                                      0, down, 0, 0,        //
                                                      0, 0, -limit, scale,  //
                                                      0, 0, -1, 0})};
}

double depth_buffer_value(double depth_world, const Frustum& frustum, bool orthographic) {
  const double near = frustum.near_world, far = frustum.far_world;
  const double depth = std::clamp(depth_world, near, far);
  // 1 at the near plane and 0 at the far one: reversed values far away keep their digits.
  const double nearness =
      orthographic ? (far - depth) / (far - near) : (1 / depth - 1 / far) / (1 / near - 1 / far);
  return frustum.clip.far_z > frustum.clip.near_z ? 1 - nearness : nearness;
}

}  // namespace gvx::scene
