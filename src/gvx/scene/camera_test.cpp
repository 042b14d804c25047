#include "gvx/scene/camera.h"

#include <cmath>

#include <gtest/gtest.h>

namespace gvx::scene {
namespace {

TEST(Camera, text_and_back_is_exact) {
  const Camera camera{{1.0 / 3, -2e-7, 3}, {0, 1e9, 0.1}, {0, 0, 1}, 33.3, 0};
  EXPECT_EQ(parse_camera(to_text(camera), Camera{}).value(), camera);
  Camera flat = camera;
  flat.height_world = 12.5;
  const Camera back = parse_camera(to_text(flat), Camera{}).value();
  EXPECT_EQ(back.height_world, 12.5);
  EXPECT_TRUE(back.orthographic());
}

TEST(Camera, bad_texts_are_errors_that_say_what) {
  for (const char* text : {"eye", ";;", "fov=30;height=2", "height=fit;fov=30", "up=0,0,1;up=0,1,0",
                           "eye=1,2", "eye=1,2,x", "fov=200", "fov=nan", "where=1,2,3", "height=-1",
                           "eye=0,0,0;target=0,0,0", "eye=0,0,5;target=0,0,0;up=0,0,1"}) {
    const auto camera = parse_camera(text, Camera{});
    ASSERT_FALSE(camera.ok()) << text;
    EXPECT_NE(camera.error().message.find("expected origin="), std::string::npos) << text;
  }
}

TEST(Camera, an_up_that_was_not_given_is_not_along_the_view) {
  const Camera z_up{{1, 2, 3}, {0, 0, 0}, {0, 0, 1}, 30, 0};
  for (const char* above : {"eye=0.5,0.5,3;target=0.5,0.5,0", "eye=0,0,-2", "origin=1,1,1;eye=0,0,1e-9"}) {
    EXPECT_EQ(parse_camera(above, z_up).value().up, Vec3d(0, 1, 0)) << above;
  }
  EXPECT_EQ(parse_camera("eye=0,7,0", z_up).value().up, Vec3d(0, 0, 1));
  EXPECT_EQ(parse_camera("eye=0,7,0", Camera{}).value().up, Vec3d(0, 0, 1));
  EXPECT_EQ(parse_camera("eye=0,1e-3,7", z_up).value().up, Vec3d(0, 0, 1));
  EXPECT_FALSE(parse_camera("eye=0,0,7;up=0,0,1", z_up).ok());
  EXPECT_FALSE(parse_camera("up=0,0,0", z_up).ok());
  const Camera flat = parse_camera("eye=0,0,7;height=5", z_up).value();
  EXPECT_EQ(flat.up, Vec3d(0, 1, 0));
  EXPECT_TRUE(make_view(flat, 1, 1).ok());
}

TEST(Camera, centre_ray_meets_the_target_and_pixels_are_as_wide_as_said) {
  const Camera camera{{3, 2, 1}, {-1, 0, 4}, {0, 1, 0}, 40, 0};
  const CameraView view = make_view(camera, 64, 48).value();
  const Ray centre = view.pixel_ray(31.5, 23.5);
  EXPECT_NEAR(length(cross(centre.direction, normalize(camera.target - camera.eye))), 0, 1e-12);
  const Vec3d top = view.pixel_ray(31.5, -0.5).direction, bottom = view.pixel_ray(31.5, 47.5).direction;
  EXPECT_NEAR(std::acos(dot(top, bottom)) * 180 / M_PI, 40, 1e-9);
  EXPECT_GT(dot(top, view.up), 0);
  EXPECT_GT(dot(view.pixel_ray(63, 24).direction, view.right), 0);
}

TEST(Camera, a_picture_without_pixels_is_an_error) {
  EXPECT_FALSE(make_view(Camera{}, 0, 10).ok());
  EXPECT_FALSE(make_view(Camera{}, 10, 0).ok());
  EXPECT_TRUE(make_view(Camera{}, 1, 1).ok());
}

TEST(Camera, frame_box_shows_every_corner) {
  const Affine3 to_world{{{2, 0, 0}, {0, 3, 0.5}, {0, 0, 1}}, {10, 20, 30}};
  const Box3d box{{0, 0, 0}, {1, 0.5, 0.25}};
  for (const double aspect : {0.5, 1.0, 2.0}) {
    const Camera camera = frame_box(box, to_world, true, aspect);
    const CameraView view = make_view(camera, static_cast<std::uint32_t>(1000 * aspect), 1000).value();
    double reach = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p =
          to_world.point({corner & 1 ? 1.0 : 0.0, corner & 2 ? 0.5 : 0.0, corner & 4 ? 0.25 : 0.0});
      const Vec3d d = p - view.eye;
      const double depth = dot(d, view.forward);
      ASSERT_GT(depth, 0);
      reach = std::max({reach, std::abs(dot(d, view.right)) / depth / view.pixel / view.half_width,
                        std::abs(dot(d, view.up)) / depth / view.pixel / view.half_height});
    }
    EXPECT_LT(reach, 1);
    EXPECT_GT(reach, 0.8);
  }
}

}  // namespace
}  // namespace gvx::scene
