#include "gvx/scene/scene_items.h"

#include <charconv>
#include <string>
#include <utility>

#include "gvx/scene/field_kinds.h"
#include "gvx/scene/scene_limits.h"

namespace gvx::scene {
namespace {

using Json = nlohmann::json;

constexpr NumberRange kFieldOfView{.least = 0, .most = 180, .open = true};
constexpr NumberRange kPercent{0, 100};
constexpr NumberRange kOpacityFactor{0, 1000};

Vec3d vector_of(const std::vector<double>& row, std::size_t first = 0) {
  return {row[first], row[first + 1], row[first + 2]};
}

std::optional<Vec3d> vector_of(const std::optional<std::vector<double>>& row) {
  return row ? std::optional(vector_of(*row)) : std::nullopt;
}

std::vector<NumberRange> three(NumberRange range) {
  return {range, range, range};
}

CameraParts read_camera_fields(JsonFields& fields, const std::string& place) {
  CameraParts camera;
  camera.origin = fields.long_row("origin");
  camera.eye = vector_of(fields.row("eye", three(kAny)));
  camera.target = vector_of(fields.row("target", three(kAny)));
  camera.up = vector_of(fields.row("up", three(kAny)));
  camera.fov_degrees = fields.number("fov", kFieldOfView);
  const Json* height = fields.any("height");
  camera.fit_height = height != nullptr && *height == "fit";
  if (!camera.fit_height) camera.height_world = fields.number("height", kAboveZero);
  if (camera.fov_degrees && height != nullptr) fields.fail(place, "fov or height", "both");
  return camera;
}

Result<CameraParts> camera_of(const Json& object, const std::string& place) {
  JsonFields fields(object, place);
  CameraParts camera = read_camera_fields(fields, place);
  if (const auto view = fields.choice("view", kSideNames)) camera.view = static_cast<Side>(*view);
  if (camera.view && camera.eye) fields.fail(place, "view or eye", "both");
  GVX_TRY(fields.finish());
  return camera;
}

Result<KeyFrameParts> read_key_frame(const Json& object, const std::string& place) {
  JsonFields fields(object, place);
  KeyFrameParts key;
  const auto frame = fields.number("frame", kAny);
  if (frame) key.frame = *frame;
  key.camera = read_camera_fields(fields, place);
  if (key.camera.fit_height) fields.fail(fields.place_of("height"), kAboveZero.text(), "'fit'");
  GVX_TRY(fields.finish());
  if (!frame) return field_error(place + ".frame", "a number", "nothing");
  return key;
}

Result<FunctionParts> read_function(const Json& value, const std::string& place) {
  FunctionParts function;
  if (value.is_string() && !value.get_ref<const std::string&>().empty()) {
    function.from = value.get<std::string>();
    return function;
  }
  if (!value.is_object()) return field_error(place, "a name or an object", describe(value));
  JsonFields fields(value, place);
  function.from = fields.text("from").value_or("");
  for (const auto& row : fields.rows("colors", {kAny, kShare, kShare, kShare})) {
    function.colors.push_back({row[0], vector_of(row, 1)});
  }
  for (const auto& row : fields.rows("opacities", {kAny, kShare}))
    function.opacities.push_back({row[0], row[1]});
  function.unit_distance = fields.number("unitDistance", {.least = 0});
  for (const auto& row : fields.rows("gradients", {{.least = 0}, kShare})) {
    function.gradients.push_back({row[0], row[1]});
  }
  if (const auto window = fields.row("window", {kAny, kAboveZero})) {
    function.window = {(*window)[0], (*window)[1]};
  }
  if (const auto range = fields.row("percentile", {kPercent, kPercent})) {
    function.percentiles = {(*range)[0], (*range)[1]};
    if (!((*range)[0] < (*range)[1])) {
      fields.fail(fields.place_of("percentile"), "the first below the second",
                  fields.any("percentile")->dump());
    }
  }
  if (function.window && function.percentiles) fields.fail(place, "window or percentile", "both");
  function.opacity = fields.number("opacity", kOpacityFactor);
  GVX_TRY(fields.finish());
  const bool chosen =
      function.colors.empty() && function.opacities.empty() &&
      (function.window || function.percentiles || function.opacity || !function.gradients.empty());
  if (function.from.empty() && !chosen && (function.colors.empty() || function.opacities.empty())) {
    return field_error(place, "colors and opacities, or from", "only some of them");
  }
  // Points out of order are told here, where their place is known; what `from` names is ordered by itself.
  if (const auto whole = function.over({{{0, {}}}, {{0, 0}}}, {}); !whole.ok()) {
    return Error{place + ": " + whole.error().message};
  }
  return function;
}

Result<Light> read_light(const Json& object, const std::string& place) {
  JsonFields fields(object, place);
  Light light;
  if (const auto kind = fields.choice("kind", kLightKindNames)) light.kind = static_cast<LightKind>(*kind);
  const auto where = vector_of(fields.row("place", three(kAny)));
  if (where) light.place = *where;
  if (const auto color = vector_of(fields.row("color", three(kWeight)))) light.color = Vec3f(*color);
  GVX_TRY(fields.finish());
  if (!where) return field_error(place + ".place", "a list of 3 numbers", "nothing");
  if (light.kind != LightKind::point && !(length(light.place) > 0)) {
    return field_error(place + ".place", "a direction", "[0,0,0]");
  }
  return light;
}

template <typename Parts, typename Read>
void read_object(JsonFields& fields, const char* name, Parts& parts, Read read) {
  const Json* value = fields.any(name);
  if (value == nullptr) return;
  auto result = read(*value, fields.place_of(name));
  if (!result.ok()) return fields.take(result.error());
  parts = std::move(result).value();
}

WrittenJson list_of(Vec3d v) {
  return {v.x, v.y, v.z};
}

template <typename Value>
void put(WrittenJson& object, const char* name, const std::optional<Value>& value) {
  if (value) object[name] = *value;
}
void put(WrittenJson& object, const char* name, const std::optional<Vec3d>& value) {
  if (value) object[name] = list_of(*value);
}
void put_unless_empty(WrittenJson& object, const char* name, WrittenJson value) {
  if (!value.empty()) object[name] = std::move(value);
}

void put_camera(WrittenJson& object, const CameraParts& camera) {
  if (const auto& o = camera.origin) object["origin"] = {to_text(o->x), to_text(o->y), to_text(o->z)};
  put(object, "eye", camera.eye);
  put(object, "target", camera.target);
  put(object, "up", camera.up);
  put(object, "fov", camera.fov_degrees);
  put(object, "height", camera.height_world);
  if (camera.fit_height) object["height"] = "fit";
  if (camera.view) object["view"] = kSideNames[static_cast<std::size_t>(*camera.view)];
}

WrittenJson to_object(const FunctionParts& function) {
  if (function == FunctionParts{.from = function.from}) return function.from;
  WrittenJson object = WrittenJson::object(), colors = WrittenJson::array(), opacities = WrittenJson::array(),
              gradients = WrittenJson::array();
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

}  // namespace

void read_camera(JsonFields& fields, CameraParts& camera) {
  read_object(fields, "camera", camera, camera_of);
}

void read_camera_path(JsonFields& fields, std::vector<KeyFrameParts>& path) {
  read_items(fields, "cameraPath", path, read_key_frame);
}

void read_functions(JsonFields& fields, std::vector<FunctionParts>& functions) {
  std::vector<FunctionParts> several;
  read_items(fields, "functions", several, read_function);
  if (several.size() > kMaxChannels) {
    fields.fail(fields.place_of("functions"), "at most " + std::to_string(kMaxChannels),
                std::to_string(several.size()));
  }
  FunctionParts one;
  read_object(fields, "function", one, read_function);
  if (one != FunctionParts{} && !several.empty()) {
    fields.fail(fields.place_of("function"), "function or functions", "both");
  }
  if (one != FunctionParts{}) several = {one};
  if (!several.empty()) functions = std::move(several);
}

void read_labels(JsonFields& fields, std::optional<LabelParts>& labels) {
  const Json* value = fields.any("labels");
  if (value == nullptr) return;
  if (value->is_boolean()) {
    labels = LabelParts{value->get<bool>(), ""};
  } else if (!value->is_string()) {
    fields.fail(fields.place_of("labels"), "true, false or the name of a file", describe(*value));
  } else if (const auto table = fields.text("labels")) {
    labels = LabelParts{true, *table};
  }
}

void read_lights(JsonFields& fields, std::optional<std::vector<Light>>& lights) {
  if (fields.any("lights") == nullptr) return;
  read_items(fields, "lights", lights.emplace(), read_light);
  if (lights->size() > Lighting::kMostLights) {
    fields.fail(fields.place_of("lights"), "at most " + std::to_string(Lighting::kMostLights) + " lights",
                std::to_string(lights->size()));
  }
}

double widened(float v) {
  char text[32];
  double wide = 0;
  std::from_chars(text, std::to_chars(text, text + sizeof(text), v).ptr, wide);
  return wide;
}

void write_camera(WrittenJson& object, const CameraParts& camera) {
  WrittenJson parts = WrittenJson::object();
  put_camera(parts, camera);
  put_unless_empty(object, "camera", std::move(parts));
}

void write_camera_path(WrittenJson& object, const std::vector<KeyFrameParts>& path) {
  WrittenJson keys = WrittenJson::array();
  for (const KeyFrameParts& key : path) {
    keys.push_back({{"frame", key.frame}});
    put_camera(keys.back(), key.camera);
  }
  put_unless_empty(object, "cameraPath", std::move(keys));
}

void write_functions(WrittenJson& object, const std::vector<FunctionParts>& functions) {
  WrittenJson list = WrittenJson::array();
  for (const FunctionParts& function : functions) list.push_back(to_object(function));
  put_unless_empty(object, "functions", std::move(list));
}

void write_labels(WrittenJson& object, const std::optional<LabelParts>& labels) {
  if (!labels) return;
  if (labels->table.empty()) {
    object["labels"] = labels->enabled;
  } else {
    object["labels"] = labels->table;
  }
}

void write_lights(WrittenJson& object, const std::optional<std::vector<Light>>& lights) {
  if (!lights) return;
  object["lights"] = WrittenJson::array();
  for (const Light& light : *lights) {
    object["lights"].push_back(
        {{"kind", kLightKindNames[static_cast<std::size_t>(light.kind)]},
         {"place", list_of(light.place)},
         {"color", {widened(light.color.x), widened(light.color.y), widened(light.color.z)}}});
  }
}

}  // namespace gvx::scene
