#include "gvx/scene/scene_file.h"

#include <algorithm>
#include <array>
#include <set>

#include "gvx/core/text_file.h"
#include "gvx/scene/json_fields.h"

namespace gvx::scene {
namespace {

using Json = nlohmann::json;

constexpr NumberRange kAny{};
constexpr NumberRange kShare{0, 1};
constexpr NumberRange kAboveZero{.least = 0, .open = true};
constexpr NumberRange kPixels{1, 32768, true};
constexpr NumberRange kVoxels{1, 0x7fffffff, true};
constexpr NumberRange kComponents{1, kMaxChannels, true};
constexpr NumberRange kBytes{0, 0x1p53, true};
constexpr NumberRange kFrames{0, 0x1p31, true};
constexpr NumberRange kFieldOfView{.least = 0, .most = 180, .open = true};
constexpr NumberRange kWeight{0, 100};
constexpr NumberRange kShininess{0, 10000};
constexpr NumberRange kRays{1, 8, true};
constexpr NumberRange kSamples{1, 1000};
constexpr NumberRange kDetail{0.25, 16};
constexpr NumberRange kPercent{0, 100};
constexpr NumberRange kOpacityFactor{0, 1000};
constexpr NumberRange kLevels{1, 28, true};
constexpr NumberRange kResolution{1, 1 << 20, true};
constexpr NumberRange kOctaves{1, 32, true};
constexpr NumberRange kSeed{0, 4294967295.0, true};
constexpr NumberRange kLength{1e-6, 1e6};
constexpr NumberRange kStrength{0, 1000};
constexpr std::array<const char*, 10> kTypes = {"u8",  "i8",  "u16", "i16", "u32",
                                                "i32", "u64", "i64", "f32", "f64"};
constexpr std::array<const char*, 2> kByteOrders = {"little", "big"};

std::string item(const std::string& list, std::size_t i) {
  return list + "[" + std::to_string(i) + "]";
}

Vec3d vector_of(const std::vector<double>& row, std::size_t first = 0) {
  return {row[first], row[first + 1], row[first + 2]};
}

std::optional<Vec3d> vector_of(const std::optional<std::vector<double>>& row) {
  return row ? std::optional(vector_of(*row)) : std::nullopt;
}

std::vector<NumberRange> three(NumberRange range) {
  return {range, range, range};
}

Result<RawParts> read_raw(const Json& object, const std::string& place) {
  JsonFields fields(object, place);
  RawParts raw;
  if (const auto dimensions = vector_of(fields.row("dims", three(kVoxels))))
    raw.dimensions = Vec3i(*dimensions);
  if (const auto type = fields.choice("dtype", kTypes)) raw.type = kTypes[*type];
  if (const auto order = fields.choice("endian", kByteOrders)) raw.big_endian = *order == 1;
  if (const auto offset = fields.number("offset", kBytes)) raw.offset = static_cast<std::int64_t>(*offset);
  raw.spacing = vector_of(fields.row("spacing", three(kAboveZero)));
  if (const auto count = fields.number("components", kComponents)) raw.components = static_cast<int>(*count);
  GVX_TRY(fields.finish());
  return raw;
}

Result<GenerateParts> read_generate(const Json& object, const std::string& place) {
  JsonFields fields(object, place);
  GenerateParts parts;
  const auto whole = [&](const char* name, NumberRange range) -> std::optional<std::int64_t> {
    const auto value = fields.number(name, range);
    return value ? std::optional(static_cast<std::int64_t>(*value)) : std::nullopt;
  };
  parts.levels = whole("levels", kLevels);
  parts.resolution = whole("resolution", kResolution);
  parts.octaves = whole("octaves", kOctaves);
  parts.seed = whole("seed", kSeed);
  parts.wavelength = fields.number("wavelength", kLength);
  parts.gain = fields.number("gain", kShare);
  parts.strength = fields.number("strength", kStrength);
  parts.thickness = fields.number("thickness", kLength);
  parts.in_march = fields.boolean("inMarch");
  GVX_TRY(fields.finish());
  return parts;
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

Result<CameraParts> read_camera(const Json& object, const std::string& place) {
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
  const bool chosen = function.colors.empty() && function.opacities.empty() &&
                      (function.window || function.percentiles || function.opacity);
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

template <typename Item, typename Read>
void read_items(JsonFields& fields, const char* name, std::vector<Item>& items, Read read) {
  const Json* list = fields.list(name);
  if (list == nullptr) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    auto value = read((*list)[i], item(fields.place_of(name), i));
    if (!value.ok()) return fields.take(value.error());
    items.push_back(std::move(value).value());
  }
}

Result<LightingParts> read_lighting(const Json& object, const std::string& place) {
  JsonFields fields(object, place);
  LightingParts lighting;
  lighting.enabled = fields.boolean("enabled");
  lighting.ambient = fields.number("ambient", kWeight);
  lighting.diffuse = fields.number("diffuse", kWeight);
  lighting.specular = fields.number("specular", kWeight);
  lighting.shininess = fields.number("shininess", kShininess);
  if (object.is_object() && object.contains("lights")) lighting.lights.emplace();
  std::vector<Light> lights;
  read_items(fields, "lights", lights, read_light);
  if (lights.size() > Lighting::kMostLights) {
    fields.fail(fields.place_of("lights"), "at most " + std::to_string(Lighting::kMostLights) + " lights",
                std::to_string(lights.size()));
  }
  if (lighting.lights) lighting.lights = std::move(lights);
  GVX_TRY(fields.finish());
  return lighting;
}

template <typename Parts, typename Read>
void read_object(JsonFields& fields, const char* name, Parts& parts, Read read) {
  const Json* value = fields.any(name);
  if (value == nullptr) return;
  auto result = read(*value, fields.place_of(name));
  if (!result.ok()) return fields.take(result.error());
  parts = std::move(result).value();
}

void read_functions(JsonFields& fields, SceneFile& scene) {
  read_items(fields, "functions", scene.functions, read_function);
  if (scene.functions.size() > kMaxChannels) {
    fields.fail("functions", "at most " + std::to_string(kMaxChannels),
                std::to_string(scene.functions.size()));
  }
  const bool several = !scene.functions.empty();
  FunctionParts one;
  read_object(fields, "function", one, read_function);
  if (one == FunctionParts{}) return;
  if (several) fields.fail("function", "function or functions", "both");
  scene.functions = {one};
}

void read_labels(JsonFields& fields, SceneFile& scene) {
  const Json* value = fields.any("labels");
  if (value == nullptr) return;
  if (value->is_boolean()) {
    scene.labels = LabelParts{value->get<bool>(), ""};
  } else if (!value->is_string()) {
    fields.fail("labels", "true, false or the name of a file", describe(*value));
  } else if (const auto table = fields.text("labels")) {
    scene.labels = LabelParts{true, *table};
  }
}

Result<SceneFile> read_document(const Json& document) {
  JsonFields fields(document, "");
  SceneFile scene;
  scene.volume = fields.text("volume");
  if (const auto up = fields.choice("upAxis", kUpAxisNames)) scene.up_axis = static_cast<UpAxis>(*up);
  read_object(fields, "raw", scene.raw, read_raw);
  scene.series = fields.text("series");
  if (const auto time = fields.number("time", kFrames)) scene.time = static_cast<std::int64_t>(*time);
  scene.even_slices = fields.boolean("evenSlices");
  read_object(fields, "generate", scene.generate, read_generate);
  if (const auto size = fields.row("size", {kPixels, kPixels})) {
    scene.width = static_cast<std::uint32_t>((*size)[0]);
    scene.height = static_cast<std::uint32_t>((*size)[1]);
  }
  if (const auto rays = fields.number("antialias", kRays))
    scene.antialias = static_cast<std::uint32_t>(*rays);
  read_object(fields, "camera", scene.camera, read_camera);
  read_items(fields, "cameraPath", scene.camera_path, read_key_frame);
  if (const auto mode = fields.choice("mode", kModeNames)) scene.mode = static_cast<Mode>(*mode);
  scene.isovalue = fields.number("isovalue", kAny);
  if (const auto how = fields.choice("classification", kClassificationNames)) {
    scene.classification = static_cast<Classification>(*how);
  }
  read_functions(fields, scene);
  read_labels(fields, scene);
  read_object(fields, "lighting", scene.lighting, read_lighting);
  if (const auto clip = fields.row("clip", {kAny, kAny, kAny, kAny, kAny, kAny})) {
    scene.clip = Box3d{vector_of(*clip), vector_of(*clip, 3)};
    for (int axis = 0; axis < 3; ++axis) {
      if (!(scene.clip->minimum[axis] < scene.clip->maximum[axis])) {
        fields.fail("clip", "each minimum below its maximum", fields.any("clip")->dump());
      }
    }
  }
  scene.background = vector_of(fields.row("background", three(kShare)));
  scene.transparent = fields.boolean("transparent");
  scene.samples = fields.number("samples", kSamples);
  scene.detail = fields.number("detail", kDetail);
  scene.finest = fields.boolean("finest");
  GVX_TRY(fields.finish());
  return scene;
}

/// "line 3, column 7" of the byte that a parser counts from 1.
std::string line_and_column(const std::string& text, std::size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte > 0 ? byte - 1 : 0, text.size()));
  const auto line_start = std::find(std::make_reverse_iterator(end), text.rend(), '\n').base();
  return "line " + std::to_string(1 + std::count(text.begin(), end, '\n')) + ", column " +
         std::to_string(1 + (end - line_start));
}

/// An error also where one object has two fields of one name, of which the library would drop the first.
Result<Json> parse_json(const std::string& text) {
  std::vector<std::set<std::string>> open_objects;
  std::optional<std::string> twice;
  const auto watch = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) open_objects.emplace_back();
    if (event == Json::parse_event_t::object_end) open_objects.pop_back();
    if (event == Json::parse_event_t::key && !open_objects.back().insert(parsed.get<std::string>()).second &&
        !twice) {
      twice = describe(parsed);
    }
    return true;
  };
  try {
    Json document = Json::parse(text, watch, true, true);
    if (twice) return Error{"expected each field once, found " + *twice + " twice in one object"};
    return document;
  } catch (const Json::parse_error& error) {
    return Error{"not JSON at " + line_and_column(text, error.byte)};
  } catch (const Json::exception&) {
    return Error{"expected numbers up to 1e308, found a greater one"};
  }
}

}  // namespace

Result<SceneFile> parse_scene(const std::string& text, const std::string& name) {
  const auto in_file = [&](const Error& error) { return Error{name + ": " + error.message}; };
  const auto document = parse_json(text);
  if (!document.ok()) return in_file(document.error());
  auto scene = read_document(document.value());
  if (!scene.ok()) return in_file(scene.error());
  return scene;
}

Result<SceneFile> read_scene(const std::string& path) {
  GVX_ASSIGN(const std::string text, read_text_file(path, "a scene file"));
  return parse_scene(text, path);
}

}  // namespace gvx::scene
