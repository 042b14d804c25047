#include "gvx/scene/camera_path.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace gvx::scene {
namespace {

KeyFrame key(double frame, Vec3d eye, double fov = 30) {
  return {frame, Camera{eye, {0, 0, 0}, {0, 0, 1}, fov, 0}};
}

CameraPath uneven_path() {
  return CameraPath::create({{-2, {{9, 0, 1}, {0, 1, 0}, {0, 0, 3}, 20, 0}},
                             {0, {{0, 9, 2}, {1, 0, 0}, {0, 1, 1}, 40, 0}},
                             {1, {{-9, 1, 3}, {0, 0, 2}, {0, 0, 1}, 50, 0}},
                             {60, {{0, -8, 1.0 / 3}, {0, 0, 0}, {0.1, 0, 1}, 10, 0}}})
      .value();
}

TEST(CameraPath, meets_every_key_frame_exactly) {
  const CameraPath path = uneven_path();
  for (const KeyFrame& k : path.key_frames()) EXPECT_EQ(path.at(k.frame), k.camera) << k.frame;
}

TEST(CameraPath, is_continuous_and_so_is_its_speed) {
  const CameraPath path = uneven_path();
  constexpr double kStep = 1e-6;
  for (double frame = -3; frame <= 61; frame += 0.125) {
    const Camera before = path.at(frame - kStep), here = path.at(frame), after = path.at(frame + kStep);
    EXPECT_LT(length(after.eye - before.eye), 100 * kStep) << frame;
    EXPECT_LT(length(after.target - before.target), 100 * kStep) << frame;
    EXPECT_LT(length(normalize(after.up) - normalize(before.up)), 100 * kStep) << frame;
    EXPECT_NEAR(after.fov_degrees, before.fov_degrees, 100 * kStep) << frame;
    const bool at_an_end = frame == -2 || frame == 60;
    if (at_an_end) continue;
    EXPECT_LT(length(after.eye - 2.0 * here.eye + before.eye) / kStep, 1e-3) << frame;
  }
}

TEST(CameraPath, one_key_frame_is_a_still_and_ends_rest) {
  const CameraPath still = CameraPath::create({key(7, {1, 2, 3})}).value();
  for (const double frame : {-1e9, 0.0, 7.0, 8.5}) EXPECT_EQ(still.at(frame), still.key_frames()[0].camera);
  const CameraPath path = uneven_path();
  EXPECT_EQ(path.at(-50), path.key_frames().front().camera);
  EXPECT_EQ(path.at(1e6), path.key_frames().back().camera);
}

TEST(CameraPath, two_key_frames_are_joined_by_a_straight_line) {
  const CameraPath path = CameraPath::create({key(0, {4, 0, 0}, 20), key(10, {8, 0, 2}, 40)}).value();
  EXPECT_NEAR(length(path.at(2.5).eye - Vec3d(5, 0, 0.5)), 0, 1e-12);
  EXPECT_NEAR(path.at(5).fov_degrees, 30, 1e-12);
  EXPECT_NEAR(length(path.at(5).up - Vec3d(0, 0, 1)), 0, 1e-12);
}

TEST(CameraPath, even_frames_are_the_classic_catmull_rom_spline) {
  const Vec3d p[] = {{8, 0, 1}, {7, 3, 1}, {5, 5, 2}, {2, 6, 2}};
  const CameraPath path =
      CameraPath::create({key(0, p[0]), key(5, p[1]), key(10, p[2]), key(15, p[3])}).value();
  const Vec3d middle = (9.0 / 16) * (p[1] + p[2]) - (1.0 / 16) * (p[0] + p[3]);
  EXPECT_NEAR(length(path.at(7.5).eye - middle), 0, 1e-12);
}

TEST(CameraPath, does_not_overshoot_however_uneven_the_frames_are) {
  for (const auto& frames : {Vec3d{1, 2, 100}, Vec3d{98, 99, 100}, Vec3d{1, 99, 100}}) {
    const CameraPath path = CameraPath::create({key(0, {10, 0, 5}, 10), key(frames.x, {20, 0, 5}, 60),
                                                key(frames.y, {20, 0, 5}, 60), key(frames.z, {21, 0, 5}, 61)})
                                .value();
    double before = 0;
    for (double frame = 0; frame <= 100; frame += 0.25) {
      const Camera camera = path.at(frame);
      EXPECT_GE(camera.eye.x, before - 1e-9) << frame;
      EXPECT_LE(camera.eye.x, 21 + 1e-9) << frame;
      if (frame > frames.x && frame < frames.y) {
        EXPECT_NEAR(camera.eye.x, 20, 1e-9);
      }
      before = camera.eye.x;
    }
  }
  // An angle stays among those of its key frames even where it turns back.
  const CameraPath zoom =
      CameraPath::create({key(0, {9, 0, 0}, 170), key(1, {9, 0, 0}, 0.01), key(2, {9, 0, 0}, 40)}).value();
  for (double frame = 0; frame <= 2; frame += 0.01) EXPECT_GE(zoom.at(frame).fov_degrees, 0.01 - 1e-12);
}

TEST(CameraPath, interpolates_the_height_of_orthographic_cameras) {
  Camera a{{0, -5, 0}, {}, {0, 0, 1}, 30, 10}, b = a;
  b.height_world = 20;
  const CameraPath path = CameraPath::create({{0, a}, {4, b}}).value();
  EXPECT_NEAR(path.at(1).height_world, 12.5, 1e-12);
}

TEST(CameraPath, a_view_that_swings_through_up_stays_one) {
  Camera side = key(0, {0, 9, 0}).camera, above = key(0, {0, 0, 9}).camera;
  above.up = {0, 1, 0};
  const CameraPath path = CameraPath::create({{0, side}, {2, above}}).value();
  for (double frame = 0; frame <= 2; frame += 0.125)
    EXPECT_TRUE(make_view(path.at(frame), 1, 1).ok()) << frame;
}

TEST(CameraPath, bad_paths_are_errors_that_name_the_key_frame) {
  KeyFrame flat = key(9, {3, 0, 0});
  flat.camera.height_world = 4;
  const auto expect_error = [](std::vector<KeyFrame> keys, const char* part) {
    const auto path = CameraPath::create(std::move(keys));
    ASSERT_FALSE(path.ok()) << part;
    EXPECT_NE(path.error().message.find(part), std::string::npos) << path.error().message;
  };
  expect_error({}, "no key frames");
  expect_error({key(0, {1, 0, 0}), key(5, {2, 0, 0}), key(5, {3, 0, 0})}, "key frame 3 is not later");
  expect_error({key(0, {1, 0, 0}), key(-1, {2, 0, 0})}, "key frame 2 is not later");
  expect_error({key(0, {1, 0, 0}), flat}, "key frame 2 is not of the kind");
  KeyFrame elsewhere = key(9, {3, 0, 0});
  elsewhere.camera.origin.x = 1;
  expect_error({key(0, {1, 0, 0}), elsewhere}, "key frame 2 is not told from");
  expect_error({key(NAN, {1, 0, 0})}, "key frame 1 has no finite frame");
  expect_error({key(0, {0, 0, 0})}, "key frame 1");
}

TEST(Zoom, comes_nearer_however_far) {
  Camera camera{{3, 2, 1}, {0, 0, 0}, {0, 0, 1}, 40, 0, Vec3dd(0.25, 0.25, 0.5)};
  const Camera near = zoom(camera, 1e20);
  EXPECT_NEAR(length(near.eye) * 1e20, length(camera.eye), 1e-14);
  EXPECT_EQ(near.origin, camera.origin);
  camera.height_world = 5;
  EXPECT_EQ(zoom(camera, 2).height_world, 2.5);
  EXPECT_EQ(zoom(camera, 1), camera);
}

TEST(Orbit, keeps_distance_and_height_and_closes) {
  const Camera camera{{3, -4, 2}, {1, 0, -1}, {0, 0, 5}, 25, 0};
  EXPECT_EQ(orbit(camera, 0), camera);
  for (const double degrees : {30.0, 90.0, 217.5}) {
    const Camera turned = orbit(camera, degrees);
    EXPECT_NEAR(length(turned.eye - turned.target), length(camera.eye - camera.target), 1e-12);
    EXPECT_NEAR(turned.eye.z, camera.eye.z, 1e-12);
  }
  EXPECT_NEAR(length(orbit(camera, 360).eye - camera.eye), 0, 1e-12);
  // To the right as the camera sees it.
  const CameraView view = make_view(camera, 1, 1).value();
  EXPECT_GT(dot(orbit(camera, 10).eye - camera.eye, view.right), 0);
}

}  // namespace
}  // namespace gvx::scene
