#include "scene_flags.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "commands.h"
#include "gvx/io/header_text.h"
#include "units.h"

namespace gvx::app {
namespace {

std::vector<std::string> split(const std::string& text, char separator, std::size_t most_parts) {
  std::vector<std::string> parts;
  std::size_t start = 0;
  while (true) {
    const std::size_t end = parts.size() + 1 < most_parts ? text.find(separator, start) : std::string::npos;
    parts.push_back(text.substr(start, end == std::string::npos ? end : end - start));
    if (end == std::string::npos) return parts;
    start = end + 1;
  }
}

std::optional<std::size_t> index_of(std::span<const char* const> names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? std::nullopt : std::optional<std::size_t>(found - names.begin());
}

/// "kind:x,y,z" or "kind:x,y,z:r,g,b".
Result<scene::Light> parse_light(const std::string& text) {
  const std::vector<std::string> parts = split(text, ':', 4);
  const auto kind = index_of(scene::kLightKindNames, parts[0]);
  if (!kind || parts.size() < 2 || parts.size() > 3) {
    return Error{"--light: '" + text + "' is not camera, directional or point:x,y,z[:red,green,blue]"};
  }
  scene::Light light;
  light.kind = static_cast<scene::LightKind>(*kind);
  GVX_ASSIGN(light.place, in_flag("--light", parse_vec3(parts[1])));
  if (parts.size() == 3) {
    GVX_ASSIGN(const Vec3d color, in_flag("--light", parse_color(parts[2])));
    light.color = Vec3f(color);
  }
  return light;
}

}  // namespace

void SceneFlags::add_to(CLI::App& command) {
  const auto one_at_a_time = [](CLI::Option* option) { option->allow_extra_args(false)->check(not_empty()); };
  command
      .add_option(
          "--camera", camera_,
          "eye=x,y,z;target=x,y,z;up=x,y,z;fov=DEGREES in world space. height=H or height=fit in place of "
          "fov: an orthographic camera. Parts that are left out are chosen so that the scene is seen")
      ->check(not_empty());
  command.add_option("--view", view_, "Look from this side; not with eye= in --camera")
      ->check(CLI::IsMember(
          std::vector<std::string>(std::begin(scene::kSideNames), std::end(scene::kSideNames))));
  one_at_a_time(command.add_option(
      "--key-frame", key_frames_,
      "NUMBER:CAMERA, with CAMERA as for --camera, such as '0:eye=300,-200,100'. Several of "
      "them are a camera path"));
  functions_.add_to(command);
  one_at_a_time(
      command.add_option("--light", lights_,
                         "KIND:x,y,z[:red,green,blue], such as camera:-1,1,2, up to 8 times. KIND is camera "
                         "(x,y,z: the direction "
                         "to the light; right, up, towards the viewer), directional (the same in world "
                         "space) or point (its position)"));
  fields_.add_to(command);
}

Status SceneFlags::apply(scene::SceneFile& scene) const {
  GVX_TRY(fields_.apply(scene));
  GVX_TRY(apply_cameras(scene));
  GVX_TRY(functions_.apply(scene));
  if (!lights_.empty()) scene.lighting.lights.emplace();
  for (const std::string& text : lights_) {
    GVX_ASSIGN(scene.lighting.lights->emplace_back(), parse_light(text));
  }
  return check_mode(scene);
}

Status SceneFlags::apply_cameras(scene::SceneFile& scene) const {
  GVX_ASSIGN(const scene::CameraParts parts, camera());
  scene.camera = parts.laid_over(scene.camera);
  if (camera_.empty() && view_.empty() && key_frames_.empty()) return {};
  GVX_ASSIGN(scene.camera_path, key_frames());
  return {};
}

Status SceneFlags::check_mode(const scene::SceneFile& scene) const {
  const scene::Mode mode = scene.mode.value_or(scene::Mode::composite);
  if (fields_.given("isovalue") && mode != scene::Mode::isosurface) {
    return Error{"--isovalue: only mode isosurface has one"};
  }
  if (functions_.has_gradients() && mode != scene::Mode::composite) {
    return Error{"--gradient-opacity: only mode composite has opacities"};
  }
  return {};
}

Result<scene::CameraParts> SceneFlags::camera() const {
  auto camera = scene::parse_camera_parts(camera_);
  // Its errors begin with the flag's name but for the dashes.
  if (!camera.ok()) return Error{"--" + camera.error().message};
  scene::CameraParts parts = camera.value();
  if (const auto side = index_of(scene::kSideNames, view_)) parts.view = static_cast<scene::Side>(*side);
  if (parts.view && parts.eye) return Error{"--view " + view_ + ": expected no eye in --camera, found one"};
  return parts;
}

Result<std::vector<scene::KeyFrameParts>> SceneFlags::key_frames() const {
  std::vector<scene::KeyFrameParts> keys;
  if (!key_frames_.empty() && !view_.empty()) {
    return Error{"--view: does not go with --key-frame, which states its own cameras"};
  }
  for (const std::string& text : key_frames_) {
    const std::vector<std::string> parts = split(text, ':', 2);
    const auto frame = io::parse_number(parts[0]);
    if (parts.size() != 2 || !frame || !std::isfinite(*frame)) {
      return Error{"--key-frame: '" + text + "' is not NUMBER:CAMERA"};
    }
    GVX_ASSIGN(const scene::CameraParts camera, in_flag("--key-frame", scene::parse_camera_parts(parts[1])));
    if (camera.fit_height) return Error{"--key-frame: '" + text + "': height must be a number"};
    keys.push_back({*frame, camera});
  }
  return keys;
}

}  // namespace gvx::app
