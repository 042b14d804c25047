#include "gvx/scene/camera_matrices.h"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace gvx::scene {
namespace {

const std::vector<ClipSpace> kClipSpaces = {ClipSpace::opengl(),
                                            ClipSpace::vulkan(),
                                            ClipSpace::direct3d(),
                                            ClipSpace::opengl().reversed(),
                                            ClipSpace::vulkan().reversed(),
                                            ClipSpace::direct3d().reversed()};

class Numbers {
 public:
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  Vec3d point(double reach) {
    return {between(-reach, reach), between(-reach, reach), between(-reach, reach)};
  }

 private:
  std::mt19937 engine_{7};
};

struct Case {
  Camera camera;
  Frustum frustum;
};

/// Cameras of both kinds in every clip space, with finite and infinite far planes.
std::vector<Case> random_cases() {
  Numbers numbers;
  std::vector<Case> cases;
  for (int i = 0; i < 240; ++i) {
    const double size = std::pow(10, numbers.between(-3, 4));
    Case c;
    c.camera = {numbers.point(3 * size), numbers.point(size), numbers.point(1), numbers.between(1, 150), 0};
    if (i % 2 == 1) c.camera.height_world = size * numbers.between(0.1, 3);
    c.frustum.clip = kClipSpaces[static_cast<std::size_t>(i / 2) % kClipSpaces.size()];
    c.frustum.aspect = numbers.between(0.3, 3);
    c.frustum.near_world = size * numbers.between(0.01, 0.5);
    if (i % 2 == 1 || i % 3 == 0) c.frustum.far_world = size * numbers.between(1, 100);
    cases.push_back(c);
  }
  return cases;
}

struct ClipPoint {
  double x = 0, y = 0, z = 0;
};

ClipPoint project(const CameraMatrices& matrices, Vec3d p) {
  double in[4] = {p.x, p.y, p.z, 1};
  for (const Matrix4* m : {&matrices.view, &matrices.projection}) {
    double out[4] = {};
    for (std::size_t k = 0; k < 16; ++k) out[k % 4] += (*m)[k] * in[k / 4];
    std::copy_n(out, 4, in);
  }
  return {in[0] / in[3], in[1] / in[3], in[2] / in[3]};
}

std::string message(const Matrix4& view, const Matrix4& projection, const ClipSpace& clip) {
  const auto made = camera_from_matrices(view, projection, clip);
  return made.ok() ? "" : made.error().message;
}

CameraMatrices some_matrices(const ClipSpace& clip, double height_world = 0) {
  const Camera camera{{3, 2, 1}, {0, 0, 0.5}, {0, 0, 1}, 40, height_world};
  return matrices_of(camera, {clip, 1.5, 0.1, 20}).value();
}

double& at(Matrix4& m, int row, int column) {
  return m[static_cast<std::size_t>(4 * column + row)];
}

TEST(CameraMatrices, points_appear_in_the_pixel_whose_ray_goes_through_them) {
  Numbers numbers;
  for (const Case& c : random_cases()) {
    const std::uint32_t height = 500, width = static_cast<std::uint32_t>(500 * c.frustum.aspect);
    Frustum frustum = c.frustum;
    frustum.aspect = double(width) / height;
    const CameraMatrices matrices = matrices_of(c.camera, frustum).value();
    const CameraView view = make_view(c.camera, width, height).value();
    const double x = numbers.between(0, width), y = numbers.between(0, height);
    const Ray ray = view.pixel_ray(x - 0.5, y - 0.5);
    const double far = std::min(frustum.far_world, 50 * frustum.near_world);
    const double depth = numbers.between(frustum.near_world, far);
    const Vec3d p = ray.at(depth / dot(ray.direction, view.forward));
    const ClipPoint seen = project(matrices, p);
    EXPECT_NEAR((seen.x + 1) / 2 * width, x, 1e-6);
    EXPECT_NEAR((frustum.clip.y_down ? seen.y + 1 : 1 - seen.y) / 2 * height, y, 1e-6);
    const double least_z = std::min(frustum.clip.near_z, frustum.clip.far_z);
    EXPECT_NEAR(depth_buffer_value(depth, frustum, view.orthographic), (seen.z - least_z) / (1 - least_z),
                1e-9);
  }
}

TEST(CameraMatrices, cameras_become_matrices_and_come_back) {
  for (const Case& c : random_cases()) {
    const CameraMatrices matrices = matrices_of(c.camera, c.frustum).value();
    const auto made = camera_from_matrices(matrices.view, matrices.projection, c.frustum.clip);
    ASSERT_TRUE(made.ok()) << made.error().message;
    const Frustum& frustum = made.value().frustum;
    const CameraView before = make_view(c.camera, 100, 100).value();
    const CameraView after = make_view(made.value().camera, 100, 100).value();
    const double size = length(c.camera.eye) + 1e-3;
    EXPECT_EQ(after.orthographic, before.orthographic);
    EXPECT_NEAR(length(after.eye - before.eye), 0, 1e-9 * size);
    EXPECT_NEAR(length(after.forward - before.forward), 0, 1e-9);
    EXPECT_NEAR(length(after.right - before.right), 0, 1e-9);
    EXPECT_NEAR(length(after.up - before.up), 0, 1e-9);
    EXPECT_NEAR(after.pixel / before.pixel, 1, 1e-9);
    EXPECT_NEAR(frustum.aspect / c.frustum.aspect, 1, 1e-9);
    EXPECT_NEAR(frustum.near_world / c.frustum.near_world, 1, 1e-6);
    if (std::isinf(c.frustum.far_world)) {
      EXPECT_TRUE(std::isinf(frustum.far_world));
    } else {
      EXPECT_NEAR(frustum.far_world / c.frustum.far_world, 1, 1e-6);
    }
  }
}

// The numbers that gluPerspective(90, 2, 1, 3) and glm::perspectiveRH_ZO with y turned give.
TEST(CameraMatrices, are_those_of_opengl_and_vulkan) {
  const Camera camera{{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 90, 0};
  const auto expect = [&](const ClipSpace& clip, const Matrix4& projection) {
    const CameraMatrices matrices = matrices_of(camera, {clip, 2, 1, 3}).value();
    const Matrix4 view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1};
    for (std::size_t i = 0; i < 16; ++i) {
      EXPECT_NEAR(matrices.view[i], view[i], 1e-12) << i;
      EXPECT_NEAR(matrices.projection[i], projection[i], 1e-12) << i;
    }
  };
  expect(ClipSpace::opengl(), {0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, -2, -1, 0, 0, -3, 0});
  expect(ClipSpace::vulkan(), {0.5, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1.5, -1, 0, 0, -1.5, 0});
  expect(ClipSpace::direct3d(), {0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.5, -1, 0, 0, -1.5, 0});
}

TEST(CameraMatrices, an_eye_space_may_be_left_handed_and_numbers_may_be_floats) {
  for (const ClipSpace& clip : kClipSpaces) {
    for (const double height : {0.0, 3.0}) {
      CameraMatrices matrices = some_matrices(clip, height);
      const Camera before = camera_from_matrices(matrices.view, matrices.projection, clip).value().camera;
      for (int k = 0; k < 4; ++k) {
        at(matrices.view, 2, k) *= -1;
        at(matrices.projection, k, 2) *= -1;
      }
      for (Matrix4* matrix : {&matrices.view, &matrices.projection}) {
        for (double& number : *matrix) number = double(static_cast<float>(number));
      }
      const auto made = camera_from_matrices(matrices.view, matrices.projection, clip);
      ASSERT_TRUE(made.ok()) << made.error().message;
      EXPECT_NEAR(length(made.value().camera.eye - before.eye), 0, 1e-4);
      EXPECT_NEAR(length(made.value().camera.up - before.up), 0, 1e-6);
      EXPECT_NEAR(made.value().frustum.near_world, 0.1, 1e-4);
      EXPECT_NEAR(made.value().frustum.far_world, 20, 1e-1);
    }
  }
}

TEST(CameraMatrices, an_orthographic_eye_is_moved_to_the_middle_and_to_the_near_plane) {
  const ClipSpace clip = ClipSpace::opengl();
  // glOrtho(1, 5, -1, 1, -2, 8), seen from 0 along -z.
  const Matrix4 view = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const Matrix4 projection = {0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, -0.2, 0, -1.5, 0, -0.6, 1};
  const CameraAndFrustum made = camera_from_matrices(view, projection, clip).value();
  EXPECT_NEAR(length(made.camera.eye - Vec3d(3, 0, 2)), 0, 1e-12);
  EXPECT_NEAR(made.camera.height_world, 2, 1e-12);
  EXPECT_NEAR(made.frustum.aspect, 2, 1e-12);
  EXPECT_NEAR(made.frustum.near_world, 0, 1e-12);
  EXPECT_NEAR(made.frustum.far_world, 10, 1e-12);
}

TEST(CameraMatrices, what_no_camera_shows_is_an_error_that_says_why) {
  const ClipSpace clip = ClipSpace::opengl();
  const CameraMatrices good = some_matrices(clip), flat = some_matrices(clip, 3);
  EXPECT_EQ(message(good.view, good.projection, clip), "");
  EXPECT_NE(message(good.view, good.projection, ClipSpace::vulkan()).find("mirrored"), std::string::npos);
  EXPECT_NE(message(transposed(good.view), good.projection, clip).find("last row"), std::string::npos);
  const auto expect = [&](const CameraMatrices& from, int row, int column, double number, const char* what) {
    Matrix4 changed = from.projection;
    at(changed, row, column) = number;
    EXPECT_NE(message(from.view, changed, clip).find(what), std::string::npos)
        << row << ' ' << column << ": " << message(from.view, changed, clip);
  };
  expect(good, 0, 2, 0.1, "middle");        // off to a side
  expect(good, 1, 2, 1e-3, "middle");       // half a pixel of 1000
  expect(good, 0, 1, 0.1, "orthogonal");    // sheared
  expect(good, 2, 0, 0.3, "oblique");       // Lengyel's near plane
  expect(good, 0, 0, 0, "no inverse");      //
  expect(good, 3, 2, 0, "no inverse");      //
  expect(good, 0, 0, NAN, "not finite");    //
  expect(flat, 0, 2, 0.1, "oblique");       // a cabinet projection
  expect(good, 2, 3, 0.2, "near and far");  // reversed, where it is said not to be
}

TEST(CameraMatrices, frusta_that_cannot_be_are_errors) {
  const Camera camera{{3, 2, 1}, {0, 0, 0}, {0, 0, 1}, 40, 0};
  Camera flat = camera;
  flat.height_world = 2;
  const ClipSpace clip;
  for (const Frustum& frustum : {Frustum{clip, 0, 1, 2}, Frustum{clip, NAN, 1, 2}, Frustum{clip, 1, 0, 2},
                                 Frustum{clip, 1, 2, 2}, Frustum{clip, 1, -1, 2}, Frustum{clip, 1, 1, NAN}}) {
    EXPECT_FALSE(matrices_of(camera, frustum).ok()) << frustum.near_world;
  }
  EXPECT_TRUE(matrices_of(camera, {clip, 1, 1}).ok());
  EXPECT_FALSE(matrices_of(flat, {clip, 1, 1}).ok());
  EXPECT_TRUE(matrices_of(flat, {clip, 1, 0, 2}).ok());
  Camera nowhere = camera;
  nowhere.target = nowhere.eye;
  EXPECT_FALSE(matrices_of(nowhere, {clip, 1, 1, 2}).ok());
}

TEST(DepthBufferValue, what_is_not_between_the_planes_lies_on_the_nearer_one) {
  for (const bool orthographic : {false, true}) {
    const Frustum usual{ClipSpace::vulkan(), 1, 2, 8}, reversed{ClipSpace::vulkan().reversed(), 1, 2, 8};
    EXPECT_EQ(depth_buffer_value(0.5, usual, orthographic), 0);
    EXPECT_EQ(depth_buffer_value(INFINITY, usual, orthographic), 1);
    EXPECT_EQ(depth_buffer_value(0.5, reversed, orthographic), 1);
    EXPECT_EQ(depth_buffer_value(INFINITY, reversed, orthographic), 0);
  }
  const Frustum endless{ClipSpace::direct3d().reversed(), 1, 0.5};
  EXPECT_EQ(depth_buffer_value(INFINITY, endless, false), 0);
  EXPECT_EQ(depth_buffer_value(1e12, endless, false), 0.5e-12);
}

}  // namespace
}  // namespace gvx::scene
