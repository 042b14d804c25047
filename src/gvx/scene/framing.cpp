#include "gvx/scene/framing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace gvx::scene {
namespace {

using Points = std::vector<Vec3d>;

Points points_of(const Framing& framing) {
  const Vec3d low = framing.box.minimum, high = framing.box.maximum;
  Points points = framing.points;
  for (int i = 0; i < 8 && framing.points.empty(); ++i) {
    points.emplace_back(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  }
  for (Vec3d& point : points) point = framing.box_to_world.point(point);
  return points;
}

/// Turns v by what takes the unit vector `from` to the unit vector `to` on the shortest way; half a turn is
/// about `axis`.
Vec3d turned(Vec3d v, Vec3d from, Vec3d to, Vec3d axis) {
  const double cosine = dot(from, to);
  if (cosine < -1 + 1e-12) return 2 * dot(axis, v) * axis - v;
  const Vec3d about = cross(from, to);
  return v + cross(about, v) + (1 / (1 + cosine)) * cross(about, cross(about, v));
}

Outlook chosen_outlook(const CameraParts& given, Stance stance) {
  if (given.view) {
    const Outlook look = outlook(stance, *given.view);
    return {look.to_eye, given.up.value_or(look.up)};
  }
  const Outlook standard = standard_outlook(stance);
  if (!given.up) return standard;
  const double tall = length(*given.up);
  if (!(tall > 0)) return {standard.to_eye, *given.up};
  const Vec3d front = outlook(stance, Side::front).to_eye;
  return {turned(standard.to_eye, standard.up, *given.up / tall, front), *given.up};
}

/// Points as the camera sees them: x to the right, y up, z towards the eye, from the target on.
struct Seen {
  Points points;
  double nearest = 0;   ///< the greatest z
  double farthest = 0;  ///< of all points from the target
};

Seen seen_from(const Points& points, const Camera& camera, Vec3d to_eye) {
  Camera upright = camera;
  upright.eye = camera.target + to_eye;
  if (!(length(cross(to_eye, camera.up)) > 1e-12 * length(camera.up))) upright = with_fitting_up(upright);
  const Vec3d right = normalize(cross(-to_eye, upright.up)), up = cross(right, -to_eye);
  Seen seen;
  for (const Vec3d& point : points) {
    const Vec3d d = point - camera.target;
    seen.points.emplace_back(dot(d, right), dot(d, up), dot(d, to_eye));
    seen.nearest = seen.points.size() == 1 ? dot(d, to_eye) : std::max(seen.nearest, dot(d, to_eye));
    seen.farthest = std::max(seen.farthest, length(d));
  }
  return seen;
}

/// How much too large the points' image is: at most 1 where it fits. `place` says where a point is in the
/// picture, whose edges are at -1 and 1.
template <typename Place>
double excess(const Points& points, double fill, Place place) {
  double most = 0;
  for (int axis = 0; axis < 2; ++axis) {
    double low = INFINITY, high = -INFINITY;
    for (const Vec3d& point : points) {
      const double at = place(point)[axis];
      low = std::min(low, at);
      high = std::max(high, at);
    }
    const double reach = std::max(std::abs(low), std::abs(high));
    most = std::max({most, (high - low) / (2 * fill), reach / (0.75 + 0.25 * fill)});
  }
  return most;
}

/// The least distance from which the points fit a picture of these half angles' tangents.
double fitting_distance(const Seen& seen, double fill, Vec3d tangents) {
  const double size = seen.farthest;
  if (!(size > 0)) return 1;
  const auto fits = [&](double distance) {
    return excess(seen.points, fill, [&](Vec3d c) {
             const double depth = distance - c.z;
             return Vec3d(c.x / (depth * tangents.x), c.y / (depth * tangents.y), 0);
           }) <= 1;
  };
  constexpr int kMostSteps = 200;
  const double nearest = std::max(seen.nearest, 0.0);
  double low = 1e-9 * size, high = size;  // from `nearest` on
  for (int i = 0; i < kMostSteps && !fits(nearest + high); ++i) high *= 2;
  for (int i = 0; i < kMostSteps && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (fits(nearest + middle) ? high : low) = middle;
  }
  return nearest + high;
}

}  // namespace

Stance stance_of(UpAxis up, bool anatomical) {
  return anatomical ? Stance::patient : up == UpAxis::y ? Stance::y_up : Stance::z_up;
}

Outlook outlook(Stance stance, Side side) {
  // Of a scene with z up; with y up all is turned about x.
  const bool patient = stance == Stance::patient;
  const Vec3d front{0, patient ? 1.0 : -1.0, 0};
  Outlook look;
  switch (side) {
    case Side::front:
      look = {front, {0, 0, 1}};
      break;
    case Side::back:
      look = {-front, {0, 0, 1}};
      break;
    case Side::left:
      look = {{-1, 0, 0}, {0, 0, 1}};
      break;
    case Side::right:
      look = {{1, 0, 0}, {0, 0, 1}};
      break;
    case Side::top:
      look = {{0, 0, 1}, {0, 1, 0}};
      break;
    case Side::bottom:
      look = {{0, 0, -1}, front};
      break;
  }
  if (stance != Stance::y_up) return look;
  const auto turn = [](Vec3d v) { return Vec3d(v.x, v.z, -v.y); };
  return {turn(look.to_eye), turn(look.up)};
}

Outlook standard_outlook(Stance stance) {
  switch (stance) {
    case Stance::patient:
      return {normalize(Vec3d{-0.42, 1, 0.22}), {0, 0, 1}};
    case Stance::y_up:
      return {normalize(Vec3d{0.45, 0.35, 1}), {0, 1, 0}};
    case Stance::z_up:
      break;
  }
  return {normalize(Vec3d{-0.45, -1, 0.35}), {0, 0, 1}};
}

Camera complete_camera(const CameraParts& given, const Framing& framing) {
  const Vec3dd origin = given.origin.value_or(Vec3dd());
  Points points = points_of(framing);
  for (Vec3d& point : points) point = Vec3d(Vec3dd(point) - origin);
  const Vec3d middle = 0.5 * (framing.box.minimum + framing.box.maximum);
  const Vec3d centre(Vec3dd(framing.box_to_world.point(middle)) - origin);
  const Outlook look = chosen_outlook(given, framing.stance);

  Camera camera;
  camera.origin = origin;
  camera.target = given.target.value_or(given.origin ? Vec3d() : centre);
  camera.up = look.up;
  camera.fov_degrees = given.fov_degrees.value_or(camera.fov_degrees);
  camera.height_world = given.height_world.value_or(0);
  const bool orthographic = given.height_world || given.fit_height;
  const Vec3d way = given.eye.value_or(look.to_eye) - (given.eye ? camera.target : Vec3d());
  if (!(length(way) > 0)) {
    camera.eye = camera.target;
    return camera;
  }
  const Seen seen = seen_from(points, camera, normalize(way));
  if (orthographic && !given.height_world) {
    const double height =
        2 * excess(seen.points, framing.fill, [&](Vec3d c) { return Vec3d(c.x / framing.aspect, c.y, 0); });
    camera.height_world = height > 0 ? height : 1;
  }
  if (given.eye) {
    camera.eye = *given.eye;
  } else {
    const double tangent = std::tan(camera.fov_degrees / 2 * std::numbers::pi / 180);
    const double distance =
        orthographic ? (seen.farthest > 0 ? 2 * seen.farthest : 1)
                     : fitting_distance(seen, framing.fill, {framing.aspect * tangent, tangent, 0});
    camera.eye = camera.target + distance * look.to_eye;
  }
  return given.up ? camera : with_fitting_up(camera);
}

Camera frame_box(const Box3d& box, const Affine3& box_to_world, bool anatomical, double aspect) {
  return frame_box(box, box_to_world, anatomical, aspect, Framing().fill);
}

Camera frame_box(const Box3d& box, const Affine3& box_to_world, bool anatomical, double aspect, double fill) {
  return complete_camera({}, {box, {}, box_to_world, stance_of(UpAxis::z, anatomical), aspect, fill});
}

}  // namespace gvx::scene
