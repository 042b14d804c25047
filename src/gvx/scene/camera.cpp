#include "gvx/scene/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>
#include <vector>

#include "gvx/scene/camera_parts.h"

namespace gvx::scene {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

Error bad_camera(const std::string& what) {
  return Error{
      "camera: " + what +
      "; expected origin=x,y,z;eye=x,y,z;target=x,y,z;up=x,y,z;fov=degrees (or height=world, height=fit)"};
}

Result<double> parse_number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    return bad_camera("'" + std::string(text) + "' is not a number");
  }
  return value;
}

Result<DoubleDouble> parse_long_number(std::string_view text) {
  const auto value = parse_double_double(text);
  if (!value) return bad_camera("'" + std::string(text) + "' is not a number");
  return *value;
}

template <typename Number>
Result<Vec3<Number>> parse_vector(std::string_view text, Result<Number> (*parse)(std::string_view)) {
  Vec3<Number> v;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t comma = axis < 2 ? text.find(',') : text.size();
    if (comma == std::string_view::npos) return bad_camera("'" + std::string(text) + "' has too few numbers");
    GVX_ASSIGN(v[axis], parse(text.substr(0, comma)));
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return v;
}

std::string number_text(double v) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof(text), v).ptr);
}

std::string vector_text(Vec3d v) {
  return number_text(v.x) + ',' + number_text(v.y) + ',' + number_text(v.z);
}

bool sound_angle(double degrees) {
  return degrees > 0 && degrees < 180;
}

Error bad_angle() {
  return bad_camera("fov must be between 0 and 180 degrees");
}

bool points_along_view(const Camera& camera) {
  const Vec3d look = camera.target - camera.eye;
  return !(length(cross(look, camera.up)) > 1e-12 * length(look) * length(camera.up));
}

}  // namespace

Result<CameraView> make_view(const Camera& camera, std::uint32_t width, std::uint32_t height) {
  const Vec3d look = camera.target - camera.eye;
  const Vec3d side = cross(look, camera.up);
  if (width < 1 || height < 1)
    return Error{"camera: a picture without pixels; expected a width and a height above 0"};
  if (!(length(look) > 0)) return bad_camera("eye and target are the same point");
  if (points_along_view(camera)) return bad_camera("up points along the view");
  if (!camera.orthographic() && !sound_angle(camera.fov_degrees)) return bad_angle();
  CameraView view;
  view.eye = Vec3d(camera.eye_world());
  view.forward = normalize(look);
  view.right = normalize(side);
  view.up = cross(view.right, view.forward);
  view.orthographic = camera.orthographic();
  view.pixel =
      (view.orthographic ? camera.height_world : 2 * std::tan(camera.fov_degrees / 2 * kRadians)) / height;
  view.half_width = width / 2.0;
  view.half_height = height / 2.0;
  return view;
}

CameraParts::CameraParts(const Camera& camera) : eye(camera.eye), target(camera.target), up(camera.up) {
  if (camera.origin != Vec3dd()) origin = camera.origin;
  if (camera.orthographic()) {
    height_world = camera.height_world;
  } else {
    fov_degrees = camera.fov_degrees;
  }
}

Camera CameraParts::over(const Camera& base) const {
  Camera camera = base;
  if (origin) camera.move_origin(*origin);
  camera.eye = eye.value_or(camera.eye);
  camera.target = target.value_or(camera.target);
  camera.up = up.value_or(base.up);
  camera.fov_degrees = fov_degrees.value_or(base.fov_degrees);
  camera.height_world = height_world.value_or(fov_degrees ? 0 : base.height_world);
  return camera;
}

CameraParts CameraParts::laid_over(const CameraParts& under) const {
  CameraParts parts = under;
  if (origin) {
    if (under.eye) parts.eye = Vec3d(under.origin.value_or(Vec3dd()) + Vec3dd(*under.eye) - *origin);
    parts.target.reset();
    parts.origin = origin;
  }
  if (eye || view) {
    parts.eye = eye;
    parts.view = view;
  }
  if (target) parts.target = target;
  if (up) parts.up = up;
  if (fov_degrees || height_world || fit_height) {
    parts.fov_degrees = fov_degrees;
    parts.height_world = height_world;
    parts.fit_height = fit_height;
  }
  return parts;
}

Camera with_fitting_up(Camera camera) {
  for (const Vec3d up : {camera.up, Vec3d(0, 1, 0), Vec3d(0, 0, 1)}) {
    camera.up = up;
    if (!points_along_view(camera)) break;
  }
  return camera;
}

std::string to_text(const Camera& camera) {
  const Vec3dd& o = camera.origin;
  const bool at_zero = o == Vec3dd();
  return (at_zero ? "" : "origin=" + to_text(o.x) + ',' + to_text(o.y) + ',' + to_text(o.z) + ';') +
         "eye=" + vector_text(camera.eye) + ";target=" + vector_text(camera.target) +
         ";up=" + vector_text(camera.up) +
         (camera.orthographic() ? ";height=" + number_text(camera.height_world)
                                : ";fov=" + number_text(camera.fov_degrees));
}

Result<CameraParts> parse_camera_parts(const std::string& text) {
  CameraParts camera;
  std::vector<std::string_view> seen;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const std::string_view part = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (part.empty()) continue;
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos) return bad_camera("'" + std::string(part) + "' has no '='");
    const std::string_view name = part.substr(0, equals), value = part.substr(equals + 1);
    const auto has = [&](std::string_view other) {
      return std::find(seen.begin(), seen.end(), other) != seen.end();
    };
    if (has(name)) return bad_camera("'" + std::string(name) + "' is there twice");
    if ((name == "fov" && has("height")) || (name == "height" && has("fov"))) {
      return bad_camera("expected fov or height, found both");
    }
    seen.push_back(name);
    if (name == "origin") {
      GVX_ASSIGN(camera.origin, parse_vector(value, parse_long_number));
    } else if (name == "eye") {
      GVX_ASSIGN(camera.eye, parse_vector(value, parse_number));
    } else if (name == "target") {
      GVX_ASSIGN(camera.target, parse_vector(value, parse_number));
    } else if (name == "up") {
      GVX_ASSIGN(camera.up, parse_vector(value, parse_number));
    } else if (name == "fov") {
      GVX_ASSIGN(camera.fov_degrees, parse_number(value));
      if (!sound_angle(*camera.fov_degrees)) return bad_angle();
    } else if (name == "height") {
      camera.fit_height = value == "fit";
      if (camera.fit_height) continue;
      GVX_ASSIGN(camera.height_world, parse_number(value));
      if (!(*camera.height_world > 0)) return bad_camera("height must be above 0");
    } else {
      return bad_camera("unknown part '" + std::string(name) + "'");
    }
  }
  if (seen.empty() && !text.empty()) return bad_camera("'" + text + "' says nothing");
  return camera;
}

Result<Camera> parse_camera(const std::string& text, const Camera& defaults) {
  GVX_ASSIGN(const CameraParts parts, parse_camera_parts(text));
  if (parts.fit_height) return bad_camera("there is nothing that height=fit could frame");
  Camera camera = parts.over(defaults);
  if (!parts.up) camera = with_fitting_up(camera);
  GVX_ASSIGN(const CameraView checked, make_view(camera, 1, 1));
  (void)checked;
  return camera;
}

}  // namespace gvx::scene
