#include "scene_flags.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "commands.h"
#include "gvx/io/header_text.h"
#include "gvx/io/sample_type.h"
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
  command.add_option("--volume", volume_, "The volume, in place of the one in the scene file")
      ->check(not_empty());
  command.add_option("--size", size_, "Size of the picture in pixels, WxH (default: 1024x1024)")
      ->check(not_empty());
  command.add_option("--antialias", antialias_, "N: take NxN rays for each pixel, 1 to 8 (default: 1)");
  command
      .add_option(
          "--camera", camera_,
          "eye=x,y,z;target=x,y,z;up=x,y,z;fov=DEGREES in world space. height=H or height=fit in place of "
          "fov: an orthographic camera. Parts that are left out are chosen so that the scene is seen")
      ->check(not_empty());
  command.add_option("--view", view_, "Look from this side; not with eye= in --camera")
      ->check(CLI::IsMember(
          std::vector<std::string>(std::begin(scene::kSideNames), std::end(scene::kSideNames))));
  command
      .add_option("--up", up_axis_,
                  "The axis that points up (default: y for glTF, OBJ and PLY, z for STL and other scenes)")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kUpAxisNames), std::end(kUpAxisNames))));
  one_at_a_time(command.add_option(
      "--key-frame", key_frames_,
      "NUMBER:CAMERA, with CAMERA as for --camera, such as '0:eye=300,-200,100'. Several of "
      "them are a camera path"));
  command.add_option("--mode", mode_, "What a ray shows of the values along it (default: composite)")
      ->check(CLI::IsMember(
          std::vector<std::string>(std::begin(scene::kModeNames), std::end(scene::kModeNames))));
  command.add_option("--isovalue", isovalue_, "Physical value of the isosurface, for --mode isosurface");
  command
      .add_option(
          "--classification", classification_,
          "preintegrated (default): each step along a ray shows all values between its ends; post: it "
          "shows only the value at its centre, which is faster but can miss thin layers")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(scene::kClassificationNames),
                                                     std::end(scene::kClassificationNames))));
  functions_.add_to(command);
  one_at_a_time(
      command.add_option("--light", lights_,
                         "KIND:x,y,z[:red,green,blue], such as camera:-1,1,2, up to 8 times. KIND is camera "
                         "(x,y,z: the direction "
                         "to the light; right, up, towards the viewer), directional (the same in world "
                         "space) or point (its position)"));
  command.add_option("--ambient", ambient_, "Weight of light from all sides (default: 0.25)");
  command.add_option("--diffuse", diffuse_, "Weight of light on surfaces that face it (default: 0.75)");
  command.add_option("--specular", specular_, "Weight of highlights (default: 0.2)");
  command.add_option("--shininess", shininess_, "Exponent of highlights (default: 32)");
  shaded_option_ = command.add_flag("--shaded,!--flat", shaded_,
                                    "Shade surfaces (default), or show colours without light");
  command
      .add_option("--clip", clip_, "Show only this box: X0,Y0,Z0,X1,Y1,Z1 in fractions of the volume's size")
      ->check(not_empty());
  command
      .add_option("--background", background_,
                  "RED,GREEN,BLUE from 0 to 1 (default: 0.13,0.16,0.2; 0,0,0 for maximum, minimum and mean)")
      ->check(not_empty());
  transparent_option_ = command.add_flag("--transparent,!--opaque", transparent_,
                                         "Keep the picture's alpha and draw no background");
  finest_option_ =
      command.add_flag("--finest,!--level-of-detail", finest_,
                       "Use the finest level everywhere, even if its voxels are much smaller than a pixel");
  command.add_option("--samples", samples_, "Samples for each voxel along a ray (default: 2)");
  command.add_option("--detail", detail_,
                     "Voxels across a pixel at which a level is chosen: 2 is sharp, 1 loads a quarter of the "
                     "data (default: 2)");
  volume_flags_.add_to(command);
  add_generate_to(command);
}

void SceneFlags::add_generate_to(CLI::App& command) {
  const char* group = "Made scenes (docs/made-scenes.md says which scene has which parameters)";
  const auto add = [&](const char* name, auto& value, const char* what) {
    command.add_option(name, value, what)->group(group);
  };
  add("--levels", generate_.levels, "Number of levels");
  add("--resolution", generate_.resolution, "Voxels along the longest side of a mesh");
  add("--octaves", generate_.octaves, "Octaves of the noise");
  add("--wavelength", generate_.wavelength,
      "Wavelength of the first octave, as a fraction of the scene's cube");
  add("--gain", generate_.gain, "Strength of an octave, relative to the one before");
  add("--seed", generate_.seed, "Random seed of the noise");
  add("--strength", generate_.strength, "Strength of the noise");
  add("--thickness", generate_.thickness,
      "Thickness of the shell around a surface, as a fraction of the scene's cube");
  command
      .add_flag("--in-march", in_march_,
                "Compute noise, and densities from distances, at each sample of a ray instead of in bricks")
      ->group(group);
}

Status SceneFlags::apply(scene::SceneFile& scene) const {
  if (!volume_.empty()) scene.volume = volume_;
  if (const auto axis = index_of(kUpAxisNames, up_axis_)) scene.up_axis = static_cast<UpAxis>(*axis);
  GVX_TRY(apply_volume(scene));
  apply_generate(scene.generate);
  if (!size_.empty()) {
    GVX_ASSIGN(const Size size, in_flag("--size", parse_size(size_)));
    scene.width = size.width;
    scene.height = size.height;
  }
  if (antialias_) scene.antialias = antialias_;
  if (!camera_.empty() || !view_.empty() || !key_frames_.empty()) scene.camera_path.clear();
  if (const auto mode = index_of(scene::kModeNames, mode_)) scene.mode = static_cast<scene::Mode>(*mode);
  if (isovalue_) scene.isovalue = isovalue_;
  if (const auto how = index_of(scene::kClassificationNames, classification_)) {
    scene.classification = static_cast<scene::Classification>(*how);
  }
  GVX_TRY(functions_.apply(scene));
  GVX_TRY(apply_lighting(scene.lighting));
  if (!clip_.empty()) {
    GVX_ASSIGN(scene.clip, in_flag("--clip", parse_box(clip_)));
  }
  if (!background_.empty()) {
    GVX_ASSIGN(scene.background, in_flag("--background", parse_color(background_)));
  }
  if (transparent_option_->count() > 0) scene.transparent = transparent_;
  if (samples_) scene.samples = samples_;
  if (detail_) scene.detail = detail_;
  if (finest_option_->count() > 0) scene.finest = finest_;
  return {};
}

Status SceneFlags::apply_lighting(scene::LightingParts& lighting) const {
  if (shaded_option_->count() > 0) lighting.enabled = shaded_;
  if (ambient_) lighting.ambient = ambient_;
  if (diffuse_) lighting.diffuse = diffuse_;
  if (specular_) lighting.specular = specular_;
  if (shininess_) lighting.shininess = shininess_;
  if (lights_.empty()) return {};
  lighting.lights.emplace();
  for (const std::string& text : lights_) {
    GVX_ASSIGN(lighting.lights->emplace_back(), parse_light(text));
  }
  return {};
}

Status SceneFlags::apply_volume(scene::SceneFile& scene) const {
  GVX_ASSIGN(const io::VolumeOptions given, volume_flags_.parse());
  scene::RawParts& raw = scene.raw;
  if (given.raw.dimensions) raw.dimensions = given.raw.dimensions;
  if (given.raw.type) raw.type = io::sample_name(*given.raw.type);
  if (given.raw.big_endian) raw.big_endian = given.raw.big_endian;
  if (given.raw.offset) raw.offset = given.raw.offset;
  if (given.raw.spacing) raw.spacing = given.raw.spacing;
  if (given.raw.components) raw.components = given.raw.components;
  if (given.series) scene.series = given.series;
  if (given.time) scene.time = given.time;
  if (given.even_slices) scene.even_slices = true;
  return {};
}

void SceneFlags::apply_generate(scene::GenerateParts& parts) const {
  const auto lay = [](auto& over, const auto& given) {
    if (given) over = given;
  };
  lay(parts.levels, generate_.levels);
  lay(parts.resolution, generate_.resolution);
  lay(parts.octaves, generate_.octaves);
  lay(parts.wavelength, generate_.wavelength);
  lay(parts.gain, generate_.gain);
  lay(parts.seed, generate_.seed);
  lay(parts.strength, generate_.strength);
  lay(parts.thickness, generate_.thickness);
  if (in_march_) parts.in_march = true;
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
