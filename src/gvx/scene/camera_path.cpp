#include "gvx/scene/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "gvx/scene/camera_parts.h"

namespace gvx::scene {
namespace {

constexpr double kMostSpeed = 3;  // of the mean one on either side

double magnitude(double v) {
  return std::abs(v);
}
double magnitude(Vec3d v) {
  return length(v);
}

// An angle or a height must not leave the range of its key frames; a path may well bulge where it turns.
bool turns_back(double before, double after) {
  return before * after <= 0;
}
bool turns_back(Vec3d, Vec3d) {
  return false;
}

/// The speed at a key frame with these mean speeds over the `before_frames` before it and the `after_frames`
/// after it.
template <typename Value>
Value key_speed(Value before, double before_frames, Value after, double after_frames) {
  if (turns_back(before, after)) return Value{};
  const double share = after_frames / (before_frames + after_frames);
  const Value speed = share * before + (1 - share) * after;
  const double most = kMostSpeed * std::min(magnitude(before), magnitude(after));
  return magnitude(speed) > most ? (most / magnitude(speed)) * speed : speed;
}

/// Between key frames `i` and i + 1, `part` of the way, what `get` takes from a camera.
template <typename Get>
auto spline(const std::vector<KeyFrame>& keys, std::size_t i, double part, Get get) {
  const auto frames = [&](std::size_t k) { return keys[k + 1].frame - keys[k].frame; };
  const auto mean_speed = [&](std::size_t k) {
    return (1 / frames(k)) * (get(keys[k + 1].camera) - get(keys[k].camera));
  };
  const auto speed = [&](std::size_t k) {
    if (k == 0) return mean_speed(0);
    if (k + 1 == keys.size()) return mean_speed(k - 1);
    return key_speed(mean_speed(k - 1), frames(k - 1), mean_speed(k), frames(k));
  };
  const double s = part, s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * get(keys[i].camera) + (s3 - 2 * s2 + s) * frames(i) * speed(i) +
         (3 * s2 - 2 * s3) * get(keys[i + 1].camera) + (s3 - s2) * frames(i) * speed(i + 1);
}

}  // namespace

Result<CameraPath> CameraPath::create(std::vector<KeyFrame> key_frames) {
  if (key_frames.empty()) return Error{"camera path: no key frames"};
  for (std::size_t i = 0; i < key_frames.size(); ++i) {
    const auto bad = [&](const std::string& what) {
      return Error{"camera path: key frame " + std::to_string(i + 1) + " " + what};
    };
    const KeyFrame& key = key_frames[i];
    if (!std::isfinite(key.frame)) return bad("has no finite frame");
    if (i > 0 && !(key.frame > key_frames[i - 1].frame)) return bad("is not later than the one before it");
    if (key.camera.orthographic() != key_frames[0].camera.orthographic()) {
      return bad(
          "is not of the kind of the first: all fov (perspective) or all height (orthographic) expected");
    }
    if (!(key.camera.origin == key_frames[0].camera.origin))
      return bad("is not told from the first one's origin");
    if (const auto view = make_view(key.camera, 1, 1); !view.ok())
      return bad("is no view: " + view.error().message);
  }
  return CameraPath(std::move(key_frames));
}

Camera CameraPath::at(double frame) const {
  const auto after = std::upper_bound(key_frames_.begin(), key_frames_.end(), frame,
                                      [](double f, const KeyFrame& key) { return f < key.frame; });
  if (after == key_frames_.begin()) return key_frames_.front().camera;
  const KeyFrame& before = *(after - 1);
  if (after == key_frames_.end() || before.frame == frame) return before.camera;
  const auto i = static_cast<std::size_t>(after - key_frames_.begin()) - 1;
  const double part = (frame - before.frame) / (after->frame - before.frame);
  const auto between = [&](auto get) { return spline(key_frames_, i, part, get); };
  Camera camera;
  camera.origin = before.camera.origin;
  camera.eye = between([](const Camera& c) { return c.eye; });
  camera.target = between([](const Camera& c) { return c.target; });
  camera.up = normalize(between([](const Camera& c) { return normalize(c.up); }));
  camera.fov_degrees = between([](const Camera& c) { return c.fov_degrees; });
  camera.height_world = between([](const Camera& c) { return c.height_world; });
  // Where the view swings through it.
  return with_fitting_up(camera);
}

Camera zoom(const Camera& camera, double factor) {
  Camera nearer = camera;
  if (factor == 1) return nearer;
  nearer.eye = camera.target + (1 / factor) * (camera.eye - camera.target);
  nearer.height_world = camera.height_world / factor;
  return nearer;
}

Camera orbit(const Camera& camera, double degrees) {
  if (degrees == 0) return camera;
  const double angle = degrees * std::numbers::pi / 180;
  const Vec3d axis = normalize(camera.up), arm = camera.eye - camera.target;
  Camera turned = camera;
  turned.eye = camera.target + std::cos(angle) * arm + std::sin(angle) * cross(axis, arm) +
               (1 - std::cos(angle)) * dot(axis, arm) * axis;
  return turned;
}

}  // namespace gvx::scene
