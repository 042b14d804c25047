#include "gvx/scene/framing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace gvx::scene {
namespace {

/// Where the box's corners are in the picture, whose edges are at -1 and 1.
struct Image {
  Vec3d minimum{std::numeric_limits<double>::infinity()};
  Vec3d maximum{-std::numeric_limits<double>::infinity()};

  double width() const { return (maximum.x - minimum.x) / 2; }
  double height() const { return (maximum.y - minimum.y) / 2; }
  /// How much of the picture the box fills in the tighter direction.
  double fill() const { return std::max(width(), height()); }
  double reach() const { return std::max({-minimum.x, -minimum.y, maximum.x, maximum.y}); }
};

/// The corners are told apart by hand, not as the camera was made.
Image image_of(const Framing& framing, const Camera& camera) {
  const auto width = static_cast<std::uint32_t>(std::lround(1000 * framing.aspect));
  const CameraView view = make_view(camera, width, 1000).value();
  Image image;
  for (const double x : {framing.box.minimum.x, framing.box.maximum.x}) {
    for (const double y : {framing.box.minimum.y, framing.box.maximum.y}) {
      for (const double z : {framing.box.minimum.z, framing.box.maximum.z}) {
        const Vec3d d = framing.box_to_world.point({x, y, z}) - view.eye;
        const double depth = dot(d, view.forward);
        EXPECT_GT(depth, 0);
        const double scale = view.pixel * (view.orthographic ? 1 : depth);
        const Vec3d at{dot(d, view.right) / scale / view.half_width,
                       dot(d, view.up) / scale / view.half_height, 0};
        for (int axis = 0; axis < 2; ++axis) {
          image.minimum[axis] = std::min(image.minimum[axis], at[axis]);
          image.maximum[axis] = std::max(image.maximum[axis], at[axis]);
        }
      }
    }
  }
  return image;
}

Framing framing_of(Stance stance, double aspect = 1) {
  return {
      {{0, 0, 0}, {1, 0.5, 0.25}}, {}, {{{2, 0, 0}, {0, 3, 0.5}, {0, 0, 1}}, {10, 20, 30}}, stance, aspect};
}

Vec3d centre_of(const Framing& framing) {
  return framing.box_to_world.point(0.5 * (framing.box.minimum + framing.box.maximum));
}

constexpr std::array kStances = {Stance::z_up, Stance::y_up, Stance::patient};
constexpr std::array kSides = {Side::front, Side::back, Side::left, Side::right, Side::top, Side::bottom};

TEST(Framing, the_box_fills_four_fifths_in_the_tighter_direction) {
  CameraParts perspective, orthographic;
  orthographic.fit_height = true;
  const Box3d boxes[] = {
      {{0, 0, 0}, {1, 1, 1}}, {{-3, 0, 0}, {3, 1, 1}}, {{0, 0, 0}, {1, 1, 9}}, {{5, 5, 5}, {6, 8, 5}}};
  for (const CameraParts& kind : {perspective, orthographic}) {
    for (const Stance stance : kStances) {
      for (const double aspect : {0.4, 1.0, 2.5}) {
        for (const Box3d& box : boxes) {
          Framing framing = framing_of(stance, aspect);
          framing.box = box;
          for (std::size_t view = 0; view <= kSides.size(); ++view) {
            CameraParts given = kind;
            if (view < kSides.size()) given.view = kSides[view];
            const Camera camera = complete_camera(given, framing);
            EXPECT_EQ(camera.orthographic(), kind.fit_height);
            const Image image = image_of(framing, camera);
            EXPECT_LE(image.fill(), 0.8 + 1e-9);
            EXPECT_LE(image.reach(), 0.95 + 1e-9);
            // A rod that comes towards the eye is held back by its near end.
            EXPECT_TRUE(image.reach() > 0.95 - 1e-9 || image.fill() > 0.8 - 1e-9);
          }
        }
      }
    }
  }
}

TEST(Framing, sides_are_where_a_viewer_or_a_patient_has_them) {
  const auto eye = [](Stance stance, Side side) { return outlook(stance, side).to_eye; };
  EXPECT_EQ(eye(Stance::z_up, Side::front), Vec3d(0, -1, 0));
  EXPECT_EQ(eye(Stance::y_up, Side::front), Vec3d(0, 0, 1));
  EXPECT_EQ(eye(Stance::patient, Side::front), Vec3d(0, 1, 0));
  for (const Stance stance : kStances) {
    EXPECT_EQ(eye(stance, Side::left), Vec3d(-1, 0, 0));
    EXPECT_EQ(eye(stance, Side::right), Vec3d(1, 0, 0));
    EXPECT_EQ(eye(stance, Side::back), -eye(stance, Side::front));
    EXPECT_EQ(eye(stance, Side::top), outlook(stance, Side::front).up);
    EXPECT_EQ(eye(stance, Side::bottom), -eye(stance, Side::top));
    for (const Side side : kSides) {
      const Outlook look = outlook(stance, side);
      EXPECT_EQ(dot(look.to_eye, look.up), 0);
      EXPECT_EQ(length(look.up), 1);
    }
    // Nearer to the front than to any other side, from a little above.
    const Outlook standard = standard_outlook(stance);
    EXPECT_EQ(standard.up, outlook(stance, Side::front).up);
    EXPECT_GT(dot(standard.to_eye, eye(stance, Side::front)), 0.85);
    EXPECT_GT(dot(standard.to_eye, standard.up), 0.15);
  }
  const auto right = [](Stance stance, Side side) {
    const Outlook look = outlook(stance, side);
    return cross(look.up, look.to_eye);
  };
  // As radiologists have it, the patient's left, -x, is on the right in front and from below.
  EXPECT_EQ(right(Stance::patient, Side::front), Vec3d(-1, 0, 0));
  EXPECT_EQ(right(Stance::patient, Side::bottom), Vec3d(-1, 0, 0));
  EXPECT_EQ(right(Stance::patient, Side::top), Vec3d(1, 0, 0));
  for (const Side side : {Side::front, Side::top, Side::bottom}) {
    EXPECT_EQ(right(Stance::z_up, side), Vec3d(1, 0, 0));
    EXPECT_EQ(right(Stance::y_up, side), Vec3d(1, 0, 0));
  }
}

TEST(Framing, an_up_alone_turns_the_view_about_the_scene) {
  const Framing framing = framing_of(Stance::z_up), y_up = framing_of(Stance::y_up);
  CameraParts given;
  given.up = Vec3d(0, 2, 0);
  const Camera turned = complete_camera(given, framing), upright = complete_camera({}, y_up);
  const Vec3d a = normalize(turned.eye - turned.target), b = normalize(upright.eye - upright.target);
  EXPECT_NEAR(length(a - Vec3d(-b.x, b.y, b.z)), 0, 1e-12);  // from the other side, as with z up
  EXPECT_EQ(turned.up, Vec3d(0, 2, 0));
  for (const Vec3d up : {Vec3d(0, 0, -1), Vec3d(1, 0, 0), Vec3d(-1, 2, 0.5), Vec3d(1e-9, 0, -1)}) {
    given.up = up;
    const Camera camera = complete_camera(given, framing);
    const double above = dot(normalize(camera.eye - camera.target), normalize(up));
    EXPECT_NEAR(above, dot(standard_outlook(Stance::z_up).to_eye, Vec3d(0, 0, 1)), 1e-6);
    EXPECT_GT(image_of(framing, camera).fill(), 0.79);
  }
}

TEST(Framing, a_given_part_is_kept_and_the_others_frame_the_box) {
  const Framing framing = framing_of(Stance::z_up, 1.5);
  const Camera standard = complete_camera({}, framing);
  EXPECT_EQ(standard.fov_degrees, 30);
  EXPECT_NEAR(length(standard.target - centre_of(framing)), 0, 1e-12);

  CameraParts fov;
  fov.fov_degrees = 5;
  const Camera far = complete_camera(fov, framing);
  EXPECT_EQ(far.fov_degrees, 5);
  EXPECT_GT(length(far.eye - far.target), 5 * length(standard.eye - standard.target));
  EXPECT_NEAR(image_of(framing, far).fill(), 0.8, 1e-9);
  fov.fov_degrees = 170;
  EXPECT_GT(image_of(framing, complete_camera(fov, framing)).fill(), 0.1);

  CameraParts target;
  target.target = centre_of(framing) + Vec3d(0.8, 0, 0);
  const Camera aside = complete_camera(target, framing);
  EXPECT_EQ(aside.target, *target.target);
  EXPECT_NEAR(length(normalize(aside.eye - aside.target) - standard_outlook(Stance::z_up).to_eye), 0, 1e-12);
  EXPECT_NEAR(image_of(framing, aside).reach(), 0.95, 1e-9);

  CameraParts eye;
  eye.eye = Vec3d(0, 0, 0);
  const Camera placed = complete_camera(eye, framing);
  EXPECT_EQ(placed.eye, *eye.eye);
  EXPECT_EQ(placed.fov_degrees, 30);
  EXPECT_NEAR(length(placed.target - centre_of(framing)), 0, 1e-12);
  eye.fit_height = true;
  EXPECT_NEAR(image_of(framing, complete_camera(eye, framing)).fill(), 0.8, 1e-9);

  CameraParts height;
  height.height_world = 7;
  EXPECT_EQ(complete_camera(height, framing).height_world, 7);
  CameraParts fit;
  fit.fit_height = true;
  const Camera fitted = complete_camera(fit, framing);
  EXPECT_NEAR(7 * image_of(framing, complete_camera(height, framing)).height(),
              fitted.height_world * image_of(framing, fitted).height(), 1e-9);

  CameraParts deep;
  deep.origin = Vec3dd(DoubleDouble(10, 1e-20), DoubleDouble(20), DoubleDouble(30));
  const Camera near_origin = complete_camera(deep, framing);
  EXPECT_EQ(near_origin.origin, *deep.origin);
  EXPECT_EQ(near_origin.target, Vec3d());
}

TEST(Framing, from_straight_above_an_up_is_chosen_unless_it_is_given) {
  const Framing framing = framing_of(Stance::z_up);
  CameraParts above;
  above.eye = centre_of(framing) + Vec3d(0, 0, 9);
  above.target = centre_of(framing);
  EXPECT_EQ(complete_camera(above, framing).up, Vec3d(0, 1, 0));
  EXPECT_EQ(complete_camera(above, framing_of(Stance::y_up)).up, Vec3d(0, 1, 0));
  above.up = Vec3d(0, 0, 1);
  EXPECT_FALSE(make_view(complete_camera(above, framing), 1, 1).ok());
  CameraParts front;
  front.view = Side::front;
  front.up = Vec3d(1, 0, 0);
  const Camera rolled = complete_camera(front, framing);
  EXPECT_NEAR(length(normalize(rolled.eye - rolled.target) - Vec3d(0, -1, 0)), 0, 1e-12);
  EXPECT_NEAR(image_of(framing, rolled).fill(), 0.8, 1e-9);
}

TEST(Framing, what_is_visible_fills_the_picture_not_its_box) {
  // A ball: its image is as wide from everywhere.
  Framing framing{{{-1, -1, -1}, {1, 1, 1}}, {}, {}, Stance::y_up, 1.5};
  std::mt19937 random(1);
  std::normal_distribution<double> number;
  for (int i = 0; i < 20000; ++i)
    framing.points.push_back(normalize(Vec3d(number(random), number(random), number(random))));
  const Camera camera = complete_camera({}, framing);
  const double distance = length(camera.eye - camera.target);
  // From there the ball is seen at an angle whose sine is 1 / distance.
  const double half = std::tan(camera.fov_degrees / 2 * std::numbers::pi / 180);
  EXPECT_NEAR(1 / std::sqrt(distance * distance - 1) / half, 0.8, 0.002);
}

TEST(Framing, boxes_without_a_size_are_views_too) {
  for (const double size : {0.0, 1e-30, 1e30}) {
    const Framing framing{{{}, Vec3d(size)}, {}, {}, Stance::z_up, 1};
    CameraParts flat;
    flat.fit_height = true;
    EXPECT_TRUE(make_view(complete_camera({}, framing), 8, 8).ok()) << size;
    EXPECT_TRUE(make_view(complete_camera(flat, framing), 8, 8).ok()) << size;
  }
}

TEST(CameraParts, laid_over_others_replace_what_they_contradict) {
  CameraParts under, eye, view, fit;
  under.eye = Vec3d(1, 2, 3);
  under.up = Vec3d(0, 1, 0);
  under.fov_degrees = 20;
  view.view = Side::top;
  eye.eye = Vec3d(4, 5, 6);
  fit.fit_height = true;
  EXPECT_EQ(view.laid_over(under).view, Side::top);
  EXPECT_FALSE(view.laid_over(under).eye);
  EXPECT_EQ(view.laid_over(under).fov_degrees, 20);
  EXPECT_EQ(eye.laid_over(view).eye, eye.eye);
  EXPECT_FALSE(eye.laid_over(view).view);
  EXPECT_TRUE(fit.laid_over(under).fit_height);
  EXPECT_FALSE(fit.laid_over(under).fov_degrees);
  EXPECT_FALSE(under.laid_over(fit).fit_height);
  EXPECT_EQ(under.laid_over(fit).up, under.up);
  CameraParts origin;
  origin.origin = Vec3dd(DoubleDouble(1), DoubleDouble(1), DoubleDouble(1));
  EXPECT_EQ(origin.laid_over(under).eye, Vec3d(0, 1, 2));
  EXPECT_FALSE(origin.laid_over(under).target);
}

}  // namespace
}  // namespace gvx::scene
