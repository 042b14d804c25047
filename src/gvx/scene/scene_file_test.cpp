#include "gvx/scene/scene_file.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

namespace gvx::scene {
namespace {

using Json = nlohmann::json;

const char* const kEverything = R"({
  "volume": "head.gvx",
  "raw": {"dims": [4, 5, 6], "dtype": "i16", "endian": "big", "offset": 12, "spacing": [1, 0.5, 2], "components": 2},
  "generate": {"levels": 9, "resolution": 300, "octaves": 7, "seed": 4, "wavelength": 0.25, "gain": 0.5,
               "strength": 1.5, "thickness": 0.05, "inMarch": true},
  "size": [640, 480],
  "antialias": 2,
  "camera": {"eye": [1, 2, 3], "target": [0.1, 0, 0], "up": [0, 0, 1], "fov": 25},
  "cameraPath": [{"frame": 0, "eye": [1, 2, 3]}, {"frame": 24.5, "target": [0, 0, 1], "height": 3}],
  "mode": "isosurface",
  "isovalue": -200.5,
  "classification": "post",
  "functions": ["ct-bone",
                {"from": "maps/warm.json", "gradients": [[0, 0], [100, 1]]},
                {"colors": [[0, 0, 0, 0], [10, 1, 0.5, 0]], "opacities": [[0, 0], [10, 0.9]], "unitDistance": 2}],
  "lighting": {"enabled": true, "ambient": 0.3, "diffuse": 0.6, "specular": 0.1, "shininess": 20,
               "lights": [{"place": [1, 1, 1]},
                          {"kind": "directional", "place": [0, 0, 1], "color": [1, 0.5, 0.25]},
                          {"kind": "point", "place": [0, 0, 0]}]},
  "clip": [0, 0, 0, 0.5, 1, 1],
  "background": [0.1, 0.2, 0.3],
  "transparent": false,
  "samples": 3,
  "detail": 1.5,
  "finest": true
})";

std::string error_of(const std::string& text) {
  const auto scene = parse_scene(text, "a.json");
  EXPECT_FALSE(scene.ok()) << text;
  if (scene.ok()) return "";
  EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
  EXPECT_EQ(scene.error().message.rfind("a.json: ", 0), 0u) << scene.error().message;
  return scene.error().message;
}

TEST(LightingParts, more_lights_than_there_can_be_are_counted_and_not_taken) {
  LightingParts parts;
  parts.lights.emplace(Lighting::kMostLights + 1);
  EXPECT_EQ(parts.over(Lighting()).lights, Lighting::kMostLights + 1);
  Lighting lighting;
  lighting.lights = Lighting::kMostLights + 1;
  EXPECT_EQ(LightingParts(lighting).lights->size(), std::size_t{Lighting::kMostLights});
}

TEST(SceneFile, reads_every_field) {
  const SceneFile scene = parse_scene(kEverything, "a.json").value();
  EXPECT_EQ(scene.volume, "head.gvx");
  EXPECT_EQ(scene.raw, (RawParts{Vec3i{4, 5, 6}, "i16", true, 12, Vec3d{1, 0.5, 2}, 2}));
  EXPECT_EQ(scene.generate, (GenerateParts{9, 300, 7, 4, 0.25, 0.5, 1.5, 0.05, true}));
  EXPECT_EQ(scene.width, 640u);
  EXPECT_EQ(scene.height, 480u);
  EXPECT_EQ(scene.antialias, 2u);
  EXPECT_EQ(scene.camera, CameraParts(Camera{{1, 2, 3}, {0.1, 0, 0}, {0, 0, 1}, 25, 0}));
  ASSERT_EQ(scene.camera_path.size(), 2u);
  EXPECT_EQ(scene.camera_path[1].frame, 24.5);
  EXPECT_EQ(scene.camera_path[1].camera.height_world, 3);
  EXPECT_FALSE(scene.camera_path[1].camera.eye.has_value());
  EXPECT_EQ(scene.mode, Mode::isosurface);
  EXPECT_EQ(scene.isovalue, -200.5);
  EXPECT_EQ(scene.classification, Classification::post);
  ASSERT_EQ(scene.functions.size(), 3u);
  EXPECT_EQ(scene.functions[0].from, "ct-bone");
  EXPECT_EQ(scene.functions[1].gradients, (std::vector<GradientPoint>{{0, 0}, {100, 1}}));
  EXPECT_EQ(scene.functions[2].colors, (std::vector<ColorPoint>{{0, {0, 0, 0}}, {10, {1, 0.5, 0}}}));
  EXPECT_EQ(scene.functions[2].unit_distance, 2);
  ASSERT_EQ(scene.lighting.lights->size(), 3u);
  EXPECT_EQ((*scene.lighting.lights)[1], (Light{LightKind::directional, {0, 0, 1}, {1, 0.5, 0.25}}));
  EXPECT_EQ((*scene.lighting.lights)[2].kind, LightKind::point);
  EXPECT_EQ(scene.clip, (Box3d{{0, 0, 0}, {0.5, 1, 1}}));
  EXPECT_EQ(scene.background, Vec3d(0.1, 0.2, 0.3));
  EXPECT_EQ(scene.transparent, false);
  EXPECT_EQ(scene.samples, 3);
  EXPECT_EQ(scene.detail, 1.5);
  EXPECT_EQ(scene.finest, true);
}

TEST(SceneFile, text_and_back_is_the_same_scene) {
  const SceneFile scene = parse_scene(kEverything, "a.json").value();
  EXPECT_EQ(parse_scene(to_json(scene), "again").value(), scene);
  EXPECT_EQ(parse_scene("{}", "empty").value(), SceneFile{});
  EXPECT_EQ(to_json(SceneFile{}), "{}\n");
  SceneFile dark;
  dark.lighting.lights.emplace();
  EXPECT_EQ(parse_scene(to_json(dark), "dark").value(), dark);
  SceneFile strange;
  strange.volume = "not \xff UTF-8";
  EXPECT_TRUE(parse_scene(to_json(strange), "strange").ok());
}

TEST(SceneFile, one_function_may_stand_alone) {
  const SceneFile scene = parse_scene(R"({"function": "ct-skin"})", "a.json").value();
  ASSERT_EQ(scene.functions.size(), 1u);
  EXPECT_EQ(scene.functions[0].from, "ct-skin");
  EXPECT_NE(error_of(R"({"function": "gray", "functions": ["gray"]})").find("function: "), std::string::npos);
}

TEST(SceneFile, parts_lie_over_what_the_program_chooses) {
  const Camera framed{{0, -5, 1}, {0, 0, 1}, {0, 0, 1}, 30, 0};
  CameraParts parts;
  EXPECT_EQ(parts.over(framed), framed);
  parts.height_world = 4;
  EXPECT_TRUE(parts.over(framed).orthographic());
  parts = {};
  parts.fov_degrees = 20;
  Camera flat = framed;
  flat.height_world = 4;
  EXPECT_FALSE(parts.over(flat).orthographic());
  LightingParts lighting;
  EXPECT_EQ(lighting.over({}), Lighting{});
  lighting.ambient = 0.5;
  lighting.lights = {Light{}, Light{LightKind::point, {1, 2, 3}, {1, 1, 1}}};
  EXPECT_EQ(lighting.over({}).lights, 2);
  EXPECT_EQ(lighting.over({}).ambient, 0.5f);
  FunctionParts function;
  function.opacities = {{5, 0.5}};
  EXPECT_EQ(function.over({{{0, {1, 0, 0}}}, {{0, 1}}}).value().opacities, function.opacities);
}

TEST(SceneFile, functions_are_fitted_to_the_volume) {
  const ValueStatistics values{0, 200, {50, 30, 20, 0}};
  FunctionParts function;
  function.colors = {{0, {0, 0, 0}}, {1, {1, 1, 1}}};
  function.opacities = {{0, 0}, {1, 0.8}};
  function.window = ValueWindow{40, 20};
  function.opacity = 0.5;
  const TransferFunction in_window = function.over({}, values).value();
  EXPECT_EQ(in_window.opacities, (std::vector<OpacityPoint>{{30, 0}, {50, 0.4}}));
  EXPECT_EQ(in_window.colors.back().value, 50);
  function.window.reset();
  function.percentiles = PercentileRange{50, 80};
  const TransferFunction in_percentiles = function.over({}, values).value();
  EXPECT_DOUBLE_EQ(in_percentiles.opacities.front().value, 50);
  EXPECT_DOUBLE_EQ(in_percentiles.opacities.back().value, 100);
  // Where next to all voxels have one value there still is a range.
  function.percentiles = PercentileRange{10, 10.001};
  const TransferFunction narrow = function.over({}, values).value();
  EXPECT_GE(narrow.opacities.back().value - narrow.opacities.front().value, 0.19);
}

TEST(SceneFile, fitted_functions_and_labels_come_back_from_their_text) {
  for (const char* text :
       {R"({"function": {"window": [40, 400]}})", R"({"function": {"from": "mr", "percentile": [1, 99.5]}})",
        R"({"functions": [{"opacity": 0.25}, {"from": "gray", "window": [-0.5, 0.25], "opacity": 3}]})",
        R"({"labels": true})", R"({"labels": false})", R"({"labels": "table.txt"})"}) {
    const SceneFile scene = parse_scene(text, "a.json").value();
    EXPECT_NE(scene, SceneFile{}) << text;
    EXPECT_EQ(parse_scene(to_json(scene), "again").value(), scene) << to_json(scene);
  }
}

TEST(SceneFile, errors_name_the_field_what_was_expected_and_what_was_found) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "not JSON at line 1, column 1"},
      {"{\n  \"mode\": ,\n}", "not JSON at line 2, column 11"},
      {"[]", "a.json: expected an object, found a list of 0"},
      {R"({"colour": 1})", "found the unknown field 'colour'"},
      {R"({"size": 5})", "size: expected a list of 2 numbers, found 5"},
      {R"({"size": [640, 480.5]})", "size[1]: expected a whole number from 1 to 32768, found 480.5"},
      {R"({"antialias": 9})", "antialias: expected a whole number from 1 to 8, found 9"},
      {R"({"camera": {"fov": 180}})", "camera.fov: expected a number between 0 and 180, found 180"},
      {R"({"camera": {"fov": 10, "height": 1}})", "camera: expected fov or height, found both"},
      {R"({"cameraPath": [{"eye": [0, 0, 1]}]})", "cameraPath[0].frame: expected a number, found nothing"},
      {R"({"mode": "xray"})",
       "mode: expected one of composite, maximum, minimum, mean, isosurface, found 'xray'"},
      {R"({"isovalue": "high"})", "isovalue: expected a number, found 'high'"},
      {R"({"isovalue": 1e999})", "expected numbers up to"},
      {R"({"functions": "gray"})", "functions: expected a list, found 'gray'"},
      {R"({"function": {"colors": [[0, 1, 1, 1]]}})", "function: expected colors and opacities"},
      {R"({"function": {"from": "gray", "opacities": [[1, 0], [0, 1]]}})", "opacity point 2 is below"},
      {R"({"functions": [{"colors": [[0, 1, 1, 1.5]], "opacities": [[0, 1]]}]})",
       "functions[0].colors[0][3]: expected a number from 0 to 1, found 1.5"},
      {R"({"function": {"window": [40, 0]}})", "function.window[1]: expected a number above 0, found 0"},
      {R"({"function": {"percentile": [5, 101]}})",
       "function.percentile[1]: expected a number from 0 to 100"},
      {R"({"function": {"percentile": [50, 50]}})",
       "function.percentile: expected the first below the second"},
      {R"({"function": {"window": [1, 1], "percentile": [1, 2]}})",
       "function: expected window or percentile, found both"},
      {R"({"function": {"opacity": -1}})", "function.opacity: expected a number from 0 to 1000, found -1"},
      {R"({"function": {"colors": [[0, 1, 1, 1]], "opacity": 1}})",
       "function: expected colors and opacities"},
      {R"({"labels": 3})", "labels: expected true, false or the name of a file, found 3"},
      {R"({"labels": ""})", "labels: expected a text, found"},
      {R"({"lighting": {"lights": [{"kind": "sun", "place": [0, 0, 1]}]}})",
       "lighting.lights[0].kind: expected one of"},
      {R"({"lighting": {"lights": [{"place": [0, 0, 0]}]}})",
       "lighting.lights[0].place: expected a direction"},
      {R"({"lighting": {"enabled": 1}})", "lighting.enabled: expected true or false, found 1"},
      {R"({"clip": [0, 0, 0, 1, 1, 0]})", "clip: expected each minimum below its maximum"},
      {R"({"volume": ""})", "volume: expected a text"},
      {R"({"samples": null})", "samples: expected a number from 1 to 1000, found null"},
      {R"({"samples": 2, "samples": 3})", "found 'samples' twice"},
  };
  for (const auto& [text, part] : cases) {
    const std::string message = error_of(text);
    EXPECT_NE(message.find(part), std::string::npos) << text << "\n" << message;
  }
  const std::string light = R"({"place": [0, 0, 1]})";
  std::string lights = light;
  for (int i = 0; i < 8; ++i) lights += "," + light;
  EXPECT_NE(error_of(R"({"lighting": {"lights": [)" + lights + "]}}").find("at most 8 lights"),
            std::string::npos);
}

TEST(SceneFile, hostile_texts_are_errors) {
  error_of(std::string(1 << 20, '['));
  error_of("{\"volume\": \"\xff\xfe\"}");
  error_of(std::string(R"({"volume":)") + std::string(100000, '{'));
  const std::string everything = kEverything;
  for (std::size_t length = 0; length < everything.size(); length += 7)
    error_of(everything.substr(0, length));
  for (std::size_t i = 0; i < everything.size(); i += 3) {
    std::string damaged = everything;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x15);
    (void)parse_scene(damaged, "a.json");  // whatever it is, it comes back
  }
}

TEST(SceneFile, files_that_cannot_be_read_are_errors) {
  const std::string path = testing::TempDir() + "gvx_scene_file.json";
  EXPECT_NE(read_scene(path + ".missing").error().message.find("cannot open"), std::string::npos);
  EXPECT_FALSE(read_scene(testing::TempDir()).ok());
  std::ofstream(path) << kEverything;
  EXPECT_EQ(read_scene(path).value(), parse_scene(kEverything, "a.json").value());
  std::ofstream(path) << "{}" << std::string(16 << 20, ' ');
  EXPECT_NE(read_scene(path).error().message.find("16 MiB"), std::string::npos);
  std::filesystem::remove(path);
}

/// docs/scene.schema.json against the reader: an object at a time, each with the document that leads to it.
class SceneSchema : public testing::Test {
 protected:
  SceneSchema() {
    std::ifstream file(GVX_SOURCE_DIR "/docs/scene.schema.json");
    schema_ = Json::parse(file);
  }

  const Json& resolved(const Json& part) const {
    if (!part.contains("$ref")) return part;
    return resolved(schema_.at(Json::json_pointer(part["$ref"].get<std::string>().substr(1))));
  }
  /// The document with `field` of the object at `place` set to `value`.
  static Json with(Json document, const Json::json_pointer& place, const char* field, const Json& value) {
    document[place][field] = value;
    return document;
  }
  static bool accepts(const Json& document) { return parse_scene(document.dump(), "a.json").ok(); }

  void expect_same_fields(const Json& object, const Json& document, const Json::json_pointer& place) {
    const std::string message = error_of(with(document, place, "no such field", 1).dump());
    const std::string start = "fields among ", end = ", found the unknown";
    const std::size_t first = message.find(start) + start.size(), last = message.find(end);
    ASSERT_LT(last, message.size()) << message;
    std::set<std::string> read, listed;
    std::stringstream names(message.substr(first, last - first));
    for (std::string name; std::getline(names, name, ',');)
      read.insert(name.substr(name.front() == ' ' ? 1 : 0));
    for (const auto& field : object["properties"].items()) listed.insert(field.key());
    EXPECT_EQ(read, listed) << place;
    for (const auto& [name, part] : object["properties"].items()) {
      expect_same_limits(resolved(part), document, place, name.c_str());
    }
  }

  /// Names, and numbers on both sides of each limit, alone or in a list of fixed length.
  void expect_same_limits(const Json& part, const Json& document, const Json::json_pointer& place,
                          const char* name) {
    const auto check = [&](const Json& value, bool accepted) {
      EXPECT_EQ(accepts(with(document, place, name, value)), accepted)
          << place << " " << name << " " << value;
    };
    if (part.contains("enum")) {
      for (const Json& value : part["enum"]) check(value, true);
      check("no such name", false);
    }
    const bool list = part.contains("items") && part.contains("minItems") && part.contains("maxItems");
    const Json& number = list ? resolved(part["items"]) : part;
    const auto check_number = [&](double value, bool accepted) {
      check(list ? Json(std::vector<double>(part["minItems"].get<std::size_t>(), value)) : Json(value),
            accepted);
    };
    const bool whole = number.contains("type") && number["type"] == "integer";
    const auto beside = [&](double limit, double direction) {
      const double next = std::nextafter(limit, direction * INFINITY);
      return whole && next != std::floor(next) ? limit + direction : next;
    };
    const std::tuple<const char*, double, bool> limits[] = {{"minimum", -1, true},
                                                            {"maximum", 1, true},
                                                            {"exclusiveMinimum", 1, false},
                                                            {"exclusiveMaximum", -1, false}};
    for (const auto& [limit, direction, accepted] : limits) {
      if (!number.contains(limit)) continue;
      check_number(number[limit], accepted);
      check_number(beside(number[limit], direction), !accepted);
    }
    if (whole) check_number(1.5, false);
    if (part.value("type", "") == "boolean") check(true, true);
  }

  Json schema_;
};

TEST_F(SceneSchema, lists_the_fields_and_the_limits_that_the_reader_knows) {
  const Json& root = schema_["properties"];
  const auto at = [](const char* pointer) { return Json::json_pointer(pointer); };
  expect_same_fields(schema_, Json::object(), at(""));
  expect_same_fields(root["raw"], {{"raw", Json::object()}}, at("/raw"));
  expect_same_fields(root["generate"], {{"generate", Json::object()}}, at("/generate"));
  expect_same_fields(root["camera"], {{"camera", Json::object()}}, at("/camera"));
  expect_same_fields(root["cameraPath"]["items"], {{"cameraPath", {{{"frame", 1}}}}}, at("/cameraPath/0"));
  expect_same_fields(schema_["$defs"]["functionObject"], {{"function", {{"from", "gray"}}}}, at("/function"));
  expect_same_fields(root["lighting"], {{"lighting", Json::object()}}, at("/lighting"));
  expect_same_fields(root["lighting"]["properties"]["lights"]["items"],
                     {{"lighting", {{"lights", {{{"place", {0, 0, 1}}}}}}}}, at("/lighting/lights/0"));
}

}  // namespace
}  // namespace gvx::scene
