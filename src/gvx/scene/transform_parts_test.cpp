#include "gvx/scene/transform_parts.h"

#include <gtest/gtest.h>

#include "gvx/scene/scene_file.h"

namespace gvx::scene {
namespace {

void expect_near(Vec3d found, Vec3d expected) {
  EXPECT_LT(length(found - expected), 1e-12) << found.x << ' ' << found.y << ' ' << found.z;
}

TEST(Transform, scales_then_rotates_then_translates) {
  TransformParts parts;
  EXPECT_EQ(parts.to_world(), Affine3());
  parts.scale = Vec3d(2, 3, -1);
  parts.rotate = Rotation{{0, 0, 5}, 90};
  parts.translate = Vec3d(10, 20, 30);
  expect_near(parts.to_world().point({1, 0, 0}), {10, 22, 30});
  expect_near(parts.to_world().point({0, 1, 0}), {7, 20, 30});
  expect_near(parts.to_world().point({0, 0, 1}), {10, 20, 29});
  EXPECT_LT(determinant(parts.to_world()), 0);
}

TEST(Transform, comes_back_from_its_text) {
  for (const char* transform :
       {R"({"translate": [1, 2, 3]})",
        R"({"rotate": {"axis": [1, 1, 0], "degrees": -30}, "scale": [1, -1, 2]})", R"({"scale": 0.5})",
        R"({"matrix": [[1, 0, 0, 5], [0, 0, -1, 6], [0, 1, 0, 7]]})",
        R"({"matrix": [[1, 0, 0, 5], [0, 2, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]})"}) {
    const std::string text =
        std::string(R"({"objects": [{"volume": "a.gvx", "mode": "maximum", "transform": )") + transform +
        R"(}, {"volume": "b.gvx", "function": "gray"}]})";
    const SceneFile scene = parse_scene(text, "a.json").value();
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_EQ(scene.objects[0].mode, Mode::maximum);
    EXPECT_NE(scene.objects[0].transform, TransformParts());
    EXPECT_EQ(scene.objects[1].functions[0].from, "gray");
    EXPECT_EQ(parse_scene(to_json(scene), "again").value(), scene) << to_json(scene);
  }
  const SceneFile half = parse_scene(R"({"objects": [{"transform": {"scale": 0.5}}]})", "a.json").value();
  EXPECT_EQ(half.objects[0].transform.scale, Vec3d(0.5));
  const SceneFile placed =
      parse_scene(R"({"objects": [{"transform": {"matrix": [[1, 0, 0, 5], [0, 0, -1, 6], [0, 1, 0, 7]]}}]})",
                  "a.json")
          .value();
  expect_near(placed.objects[0].transform.to_world().point({1, 2, 3}), {6, 3, 9});
}

TEST(Transform, errors_name_the_object) {
  const auto error_of = [](const std::string& second) {
    const auto scene = parse_scene(R"({"objects": [{"volume": "a.gvx"}, )" + second + "]}", "a.json");
    return scene.ok() ? "no error" : scene.error().message;
  };
  const auto expect = [&](const std::string& second, const std::string& part) {
    EXPECT_NE(error_of(second).find(part), std::string::npos) << error_of(second);
  };
  expect(R"({"transform": {"scale": 0}})",
         "a.json: objects[1].transform: expected a transform with an inverse");
  expect(R"({"transform": {"matrix": [[1, 0, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]]}})",
         "objects[1].transform: ");
  expect(R"({"transform": {"matrix": [[1, 0, 0, 0], [0, 1, 0, 0]]}})",
         "objects[1].transform.matrix: expected 3 or 4 rows of 4 numbers");
  expect(R"({"transform": {"matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]}})",
         "objects[1].transform.matrix[3]: expected [0,0,0,1]");
  expect(R"({"transform": {"matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]], "scale": 2}})",
         "objects[1].transform: expected matrix or translate, rotate and scale, found both");
  expect(R"({"transform": {"rotate": {"axis": [0, 0, 0], "degrees": 5}}})",
         "objects[1].transform.rotate.axis: expected a direction");
  expect(R"({"transform": {"rotate": {"axis": [0, 0, 1]}}})",
         "objects[1].transform.rotate.degrees: expected");
  expect(R"({"transform": {"turn": 5}})", "unknown field 'turn'");
  expect(R"({"size": [5, 5]})", "unknown field 'size'");
  expect(R"({"mode": "xray"})", "objects[1].mode: expected one of");
  expect("5", "objects[1]: expected an object, found 5");
  const auto both = parse_scene(R"({"volume": "a", "objects": [{"volume": "b"}]})", "a.json");
  EXPECT_NE(both.error().message.find("expected objects, or volume and the like, found both"),
            std::string::npos)
      << both.error().message;
}

}  // namespace
}  // namespace gvx::scene
