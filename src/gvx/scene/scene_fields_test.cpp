#include "gvx/scene/scene_fields.h"

#include <algorithm>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

namespace gvx::scene {
namespace {

TEST(SceneFields, each_has_a_path_and_a_flag_of_its_own) {
  std::set<std::string> paths, flags;
  for (const FieldDescription& field : scene_fields()) {
    EXPECT_TRUE(paths.insert(field.path).second) << field.path;
    if (field.flag.names == nullptr) continue;
    EXPECT_TRUE(field.flag_name().starts_with("--")) << field.path;
    EXPECT_NE(std::string(field.flag.help), "") << field.path;
    std::stringstream names(field.flag.names);
    for (std::string name; std::getline(names, name, ',');) EXPECT_TRUE(flags.insert(name).second) << name;
  }
  EXPECT_TRUE(paths.contains("generate.inMarch"));
  EXPECT_TRUE(flags.contains("!--flat"));
}

TEST(SceneFields, a_document_replaces_what_it_says_and_no_more) {
  SceneFile scene = parse_scene(R"({"volume": "a", "raw": {"dims": [1, 2, 3], "offset": 4}, "samples": 3,
                                    "functions": ["gray", "mr"]})",
                                "a.json")
                        .value();
  ASSERT_TRUE(read_over(nlohmann::json::parse(R"({"raw": {"offset": 5}, "function": "ct-bone",
                                                  "lighting": {"enabled": false}})"),
                        scene)
                  .ok());
  EXPECT_EQ(scene.volume, "a");
  EXPECT_EQ(scene.raw.dimensions, (Vec3i{1, 2, 3}));
  EXPECT_EQ(scene.raw.offset, 5);
  EXPECT_EQ(scene.samples, 3);
  EXPECT_EQ(scene.lighting.enabled, false);
  ASSERT_EQ(scene.functions.size(), 1u);
  EXPECT_EQ(scene.functions[0].from, "ct-bone");
  const Status bad = read_over({{"raw", {{"spacing", {1, 0, 1}}}}}, scene);
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().message, "raw.spacing[1]: expected a number above 0, found 0");
}

TEST(SceneFields, gradients_alone_change_the_function_that_is_chosen) {
  const SceneFile scene = parse_scene(R"({"function": {"gradients": [[0, 0], [9, 1]]}})", "a.json").value();
  ASSERT_EQ(scene.functions.size(), 1u);
  EXPECT_EQ(scene.functions[0].gradients.size(), 2u);
  EXPECT_EQ(parse_scene(to_json(scene), "again").value(), scene);
}

TEST(SceneFields, those_that_are_set_are_named) {
  GenerateParts parts;
  EXPECT_TRUE(set_fields(parts).empty());
  parts.octaves = 3;
  parts.in_march = false;
  EXPECT_EQ(set_fields(parts), (std::vector<std::string>{"octaves", "inMarch"}));
}

}  // namespace
}  // namespace gvx::scene
