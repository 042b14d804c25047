// SceneFile: parts laid over what the program would choose, and the text of it all.

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "gvx/scene/scene_file.h"

namespace gvx::scene {
namespace {

using Json = nlohmann::ordered_json;

/// The double of fewest digits that is this float: 0.2 for 0.2f.
double widened(float v) {
  char text[32];
  double wide = 0;
  std::from_chars(text, std::to_chars(text, text + sizeof(text), v).ptr, wide);
  return wide;
}

Json list_of(Vec3d v) {
  return {v.x, v.y, v.z};
}

template <typename Value>
void put(Json& object, const char* name, const std::optional<Value>& value) {
  if (value) object[name] = *value;
}
void put(Json& object, const char* name, const std::optional<Vec3d>& value) {
  if (value) object[name] = list_of(*value);
}
void put_unless_empty(Json& object, const char* name, Json value) {
  if (!value.empty()) object[name] = std::move(value);
}

Json to_object(const RawParts& raw) {
  Json object = Json::object();
  if (raw.dimensions) object["dims"] = {raw.dimensions->x, raw.dimensions->y, raw.dimensions->z};
  put(object, "dtype", raw.type);
  if (raw.big_endian) object["endian"] = *raw.big_endian ? "big" : "little";
  put(object, "offset", raw.offset);
  put(object, "spacing", raw.spacing);
  put(object, "components", raw.components);
  return object;
}

Json to_object(const GenerateParts& parts) {
  Json object = Json::object();
  put(object, "levels", parts.levels);
  put(object, "resolution", parts.resolution);
  put(object, "octaves", parts.octaves);
  put(object, "seed", parts.seed);
  put(object, "wavelength", parts.wavelength);
  put(object, "gain", parts.gain);
  put(object, "strength", parts.strength);
  put(object, "thickness", parts.thickness);
  put(object, "inMarch", parts.in_march);
  return object;
}

void put_camera(Json& object, const CameraParts& camera) {
  if (const auto& o = camera.origin) object["origin"] = {to_text(o->x), to_text(o->y), to_text(o->z)};
  put(object, "eye", camera.eye);
  put(object, "target", camera.target);
  put(object, "up", camera.up);
  put(object, "fov", camera.fov_degrees);
  put(object, "height", camera.height_world);
  if (camera.fit_height) object["height"] = "fit";
  if (camera.view) object["view"] = kSideNames[static_cast<std::size_t>(*camera.view)];
}

Json to_object(const FunctionParts& function) {
  if (function == FunctionParts{.from = function.from}) return function.from;
  Json object = Json::object(), colors = Json::array(), opacities = Json::array(), gradients = Json::array();
  for (const ColorPoint& p : function.colors) colors.push_back({p.value, p.color.x, p.color.y, p.color.z});
  for (const OpacityPoint& p : function.opacities) opacities.push_back({p.value, p.opacity});
  for (const GradientPoint& p : function.gradients) gradients.push_back({p.gradient, p.factor});
  if (!function.from.empty()) object["from"] = function.from;
  put_unless_empty(object, "colors", std::move(colors));
  put_unless_empty(object, "opacities", std::move(opacities));
  put(object, "unitDistance", function.unit_distance);
  put_unless_empty(object, "gradients", std::move(gradients));
  if (const auto& w = function.window) object["window"] = {w->level, w->width};
  if (const auto& p = function.percentiles) object["percentile"] = {p->first, p->last};
  put(object, "opacity", function.opacity);
  return object;
}

Json to_object(const LightingParts& lighting) {
  Json object = Json::object();
  put(object, "enabled", lighting.enabled);
  put(object, "ambient", lighting.ambient);
  put(object, "diffuse", lighting.diffuse);
  put(object, "specular", lighting.specular);
  put(object, "shininess", lighting.shininess);
  if (!lighting.lights) return object;
  object["lights"] = Json::array();
  for (const Light& light : *lighting.lights) {
    object["lights"].push_back(
        {{"kind", kLightKindNames[static_cast<std::size_t>(light.kind)]},
         {"place", list_of(light.place)},
         {"color", {widened(light.color.x), widened(light.color.y), widened(light.color.z)}}});
  }
  return object;
}

/// Lists of numbers on one line, all else a line each.
void write(const Json& value, std::string& text, const std::string& indent) {
  const auto nested = [](const Json& v) { return v.is_structured(); };
  if (!value.is_structured() || value.empty() ||
      (value.is_array() && std::none_of(value.begin(), value.end(), nested))) {
    text += value.dump(-1, ' ', false, Json::error_handler_t::replace);
    return;
  }
  const std::string inner = indent + "  ";
  const char* separator = "\n";
  text += value.is_array() ? '[' : '{';
  for (const auto& [key, field] : value.items()) {
    text += separator + inner;
    if (value.is_object()) text += '"' + key + "\": ";
    write(field, text, inner);
    separator = ",\n";
  }
  text += '\n' + indent + (value.is_array() ? ']' : '}');
}

}  // namespace

Result<TransferFunction> FunctionParts::over(TransferFunction base, const ValueStatistics& statistics) const {
  if (!colors.empty()) base.colors = colors;
  if (!opacities.empty()) base.opacities = opacities;
  base.unit_distance = unit_distance.value_or(base.unit_distance);
  if (!gradients.empty()) base.gradients = gradients;
  GVX_TRY(check(base));
  if (window) base = stretched(std::move(base), window->span());
  if (percentiles) {
    constexpr double kLeastWidth = 1e-3;  // of the values' range, where next to all voxels have one value
    const double first = statistics.percentile(percentiles->first / 100);
    const double last = statistics.percentile(percentiles->last / 100);
    base = stretched(std::move(base), {first, std::max(last, first + kLeastWidth * statistics.width())});
  }
  if (opacity) base = with_opacity_factor(std::move(base), *opacity);
  GVX_TRY(check(base));
  return base;
}

LightingParts::LightingParts(const Lighting& lighting)
    : enabled(lighting.enabled),
      ambient(widened(lighting.ambient)),
      diffuse(widened(lighting.diffuse)),
      specular(widened(lighting.specular)),
      shininess(widened(lighting.shininess)),
      lights(std::in_place, lighting.light,
             lighting.light + std::clamp(lighting.lights, 0, Lighting::kMostLights)) {}

Lighting LightingParts::over(const Lighting& base) const {
  Lighting lighting = base;
  const auto part = [](const std::optional<double>& value, float& target) {
    if (value) target = static_cast<float>(*value);
  };
  lighting.enabled = enabled.value_or(base.enabled);
  part(ambient, lighting.ambient);
  part(diffuse, lighting.diffuse);
  part(specular, lighting.specular);
  part(shininess, lighting.shininess);
  if (lights) {
    // Frame::make() refuses more by their number.
    lighting.lights = static_cast<int>(lights->size());
    std::copy_n(lights->begin(), std::min<std::size_t>(lights->size(), Lighting::kMostLights),
                lighting.light);
  }
  return lighting;
}

std::string to_json(const SceneFile& scene) {
  Json document = Json::object(), camera = Json::object(), path = Json::array(), functions = Json::array();
  put(document, "volume", scene.volume);
  if (scene.up_axis) document["upAxis"] = kUpAxisNames[static_cast<std::size_t>(*scene.up_axis)];
  put_unless_empty(document, "raw", to_object(scene.raw));
  put(document, "series", scene.series);
  put(document, "time", scene.time);
  put(document, "evenSlices", scene.even_slices);
  put_unless_empty(document, "generate", to_object(scene.generate));
  if (scene.width && scene.height) document["size"] = {*scene.width, *scene.height};
  put(document, "antialias", scene.antialias);
  put_camera(camera, scene.camera);
  put_unless_empty(document, "camera", std::move(camera));
  for (const KeyFrameParts& key : scene.camera_path) {
    path.push_back({{"frame", key.frame}});
    put_camera(path.back(), key.camera);
  }
  put_unless_empty(document, "cameraPath", std::move(path));
  if (scene.mode) document["mode"] = kModeNames[static_cast<std::size_t>(*scene.mode)];
  put(document, "isovalue", scene.isovalue);
  if (scene.classification) {
    document["classification"] = kClassificationNames[static_cast<std::size_t>(*scene.classification)];
  }
  for (const FunctionParts& function : scene.functions) functions.push_back(to_object(function));
  put_unless_empty(document, "functions", std::move(functions));
  if (scene.labels && !scene.labels->table.empty()) {
    document["labels"] = scene.labels->table;
  } else if (scene.labels) {
    document["labels"] = scene.labels->enabled;
  }
  put_unless_empty(document, "lighting", to_object(scene.lighting));
  if (scene.clip) {
    const Vec3d a = scene.clip->minimum, b = scene.clip->maximum;
    document["clip"] = {a.x, a.y, a.z, b.x, b.y, b.z};
  }
  put(document, "background", scene.background);
  put(document, "transparent", scene.transparent);
  put(document, "samples", scene.samples);
  put(document, "detail", scene.detail);
  put(document, "finest", scene.finest);
  std::string text;
  write(document, text, "");
  return text + "\n";
}

}  // namespace gvx::scene
