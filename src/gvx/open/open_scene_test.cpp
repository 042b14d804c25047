// From a scene's text to a volume and a view, as a server has it.

#include "gvx/open/open_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>

namespace gvx::open {
namespace {

namespace fs = std::filesystem;

class Opening : public testing::Test {
 protected:
  Opening() {
    fs::create_directories(folder_);
    options_.warn = [&](const std::string& line) { warnings_.push_back(line); };
    options_.show_work = [&](const Work& work) { work_.push_back(work); };
  }
  ~Opening() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// A raw ball of 20^3 u8 voxels, brightest in the middle.
  std::string ball() const {
    std::ofstream file(path("ball_20x20x20_uint8.raw"), std::ios::binary);
    for (int i = 0; i < 8000; ++i) {
      const double r = std::hypot(i % 20 - 9.5, i / 20 % 20 - 9.5, i / 400 - 9.5);
      file.put(static_cast<char>(std::max(0.0, 250 - 30 * r)));
    }
    return path("ball_20x20x20_uint8.raw");
  }
  Result<OpenScene> open(const std::string& json) const {
    GVX_ASSIGN(const scene::SceneFile scene, scene::parse_scene(json, "request"));
    return open_scene(scene, options_);
  }
  /// A scene of the ball with more fields.
  Result<OpenScene> open_ball(const std::string& more) const {
    return open(R"({"volume": ")" + ball() + "\"" + (more.empty() ? "" : ", ") + more + "}");
  }
  void expect_error(const Result<OpenScene>& opened, const std::string& part) const {
    ASSERT_FALSE(opened.ok()) << part;
    EXPECT_NE(opened.error().message.find(part), std::string::npos) << opened.error().message;
    EXPECT_EQ(opened.error().message.find("--"), std::string::npos) << opened.error().message;
  }

  const fs::path folder_ = fs::path(testing::TempDir()) / "gvx_open";
  OpenOptions options_;
  std::vector<std::string> warnings_;
  std::vector<Work> work_;
};

TEST_F(Opening, a_text_becomes_a_volume_and_a_view) {
  const OpenScene opened =
      open(R"({"volume": "sponge", "size": [64, 48], "mode": "maximum", "detail": 1.5, "finest": true})")
          .value();
  EXPECT_EQ(opened.volume.producer->description().n, 3u);
  EXPECT_EQ(opened.view.width, 64u);
  EXPECT_EQ(opened.view.mode, scene::Mode::maximum);
  EXPECT_EQ(opened.view.detail, 1.5);
  EXPECT_FALSE(opened.view.level_of_detail);
  EXPECT_TRUE(opened.view.opaque_background);
  EXPECT_EQ(opened.view.background, Vec3f(0, 0, 0));
  EXPECT_EQ(opened.view.functions.size(), 1u);
  EXPECT_FALSE(opened.path);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Opening, a_complete_scene_opens_to_the_same_view) {
  const OpenScene first =
      open_ball(R"("camera": {"view": "left"}, "function": {"window": [120, 60]})").value();
  const OpenScene again = open(scene::to_json(first.scene)).value();
  EXPECT_EQ(again.scene, first.scene);
  EXPECT_EQ(again.view, first.view);
}

TEST_F(Opening, a_foreign_file_becomes_a_store_and_says_how_far_it_is) {
  VoxelFormat asked;
  options_.before_build = [&](const VoxelFormat& format) {
    asked = format;
    return Status();
  };
  const OpenScene opened = open_ball("").value();
  EXPECT_EQ(asked.type, VoxelType::u8);
  ASSERT_FALSE(work_.empty());
  EXPECT_EQ(work_.back().done, work_.back().all);
  const Vec3d size = opened.volume.producer->description().extent.maximum;
  EXPECT_GT(size.x, 0);
  options_.before_build = [](const VoxelFormat&) { return Status(Error{"too large"}); };
  expect_error(open_ball(""), "too large");
}

TEST_F(Opening, an_open_volume_is_looked_at_again) {
  const OpenScene first = open_ball("").value();
  scene::SceneFile other;
  other.camera.view = scene::Side::top;
  other.functions = {{.from = "gray"}};
  const OpenScene second = look_at(first.volume, other, options_).value();
  EXPECT_EQ(second.volume.producer, first.volume.producer);
  EXPECT_NE(second.view.camera, first.view.camera);
  EXPECT_GT(second.view.camera.eye.z, second.view.camera.target.z);
}

TEST_F(Opening, key_frames_become_a_path) {
  const OpenScene opened = open_ball(R"("cameraPath": [{"frame": 1, "eye": [10, -90, 10]},
                                                        {"frame": 5, "eye": [90, 10, 10], "fov": 20}])")
                               .value();
  ASSERT_TRUE(opened.path);
  ASSERT_EQ(opened.path->key_frames().size(), 2u);
  EXPECT_EQ(opened.view.camera, opened.path->key_frames().front().camera);
  EXPECT_EQ(opened.path->key_frames().back().camera.fov_degrees, 20);
}

TEST_F(Opening, errors_name_the_field_or_the_file) {
  expect_error(open("{}"), "volume: expected");
  expect_error(open(R"({"volume": "nowhere.gvx"})"), "nowhere.gvx: cannot open");
  expect_error(open(R"({"volume": "spong"})"), "did you mean sponge?");
  expect_error(open(R"({"volume": "sponge", "generate": {"octaves": 3}})"), "sponge: octaves does not apply");
  expect_error(open(R"({"volume": "sponge", "function": "ct-bome"})"), "functions[0]: ct-bome: neither");
  expect_error(open(R"({"volume": "sponge", "labels": "none.tsv"})"), "labels: none.tsv: cannot open");
  expect_error(open(R"({"volume": "sponge", "camera": {"up": [0, 0, 0]}})"), "up: expected a direction");
  expect_error(open_ball(R"("mode": "isosurface")"), "isovalue: mode isosurface needs one");
  expect_error(open(R"({"volume": "sponge", "labels": true})"), "labels: the volume's numbers are no labels");
  expect_error(open_ball(R"("functions": ["gray", "gray"])"), "functions: 2 transfer functions");
  expect_error(open(R"({"volume": "sponge", "function": {"percentile": [1, 99]}})"),
               "functions[0].percentile: the volume has no histogram; window does the same");
  expect_error(open(R"({"volume": "repeat:3:cloud"})"), "power of 2");
}

TEST_F(Opening, objects_share_a_volume_that_they_name_alike) {
  const std::string volume = R"("volume": ")" + ball() + "\"";
  const scene::SceneFile scene =
      scene::parse_scene(R"({"objects": [{)" + volume + R"(, "function": "gray"}, {"volume": "sponge"}, {)" +
                             volume + R"(, "mode": "maximum", "transform": {"scale": -2}}]})",
                         "request")
          .value();
  const auto objects = open_objects(scene, options_).value();
  ASSERT_EQ(objects.size(), 3u);
  EXPECT_EQ(objects[0].volume.producer, objects[2].volume.producer);
  EXPECT_NE(objects[0].volume.producer, objects[1].volume.producer);
  EXPECT_EQ(objects[0].look.mode, scene::Mode::composite);
  EXPECT_EQ(objects[2].look.mode, scene::Mode::maximum);
  EXPECT_EQ(objects[0].to_world, Affine3());
  EXPECT_EQ(objects[2].to_world.point({1, 2, 3}), Vec3d(-2, -4, -6));
  const std::size_t built = work_.size();
  EXPECT_GT(built, 0u);
  expect_error(look_at(objects[0].volume, scene, options_),
               "objects: a single volume is shown by itself; expected one object");
  EXPECT_EQ(work_.size(), built);
  const OpenScene opened = open_scene(scene, options_).value();
  EXPECT_EQ(opened.objects.size(), 3u);
  EXPECT_GT(length(opened.view.camera.eye - opened.view.camera.target), 1) << "all objects are framed";
}

TEST_F(Opening, a_single_object_is_a_scene) {
  const OpenScene one =
      open(R"({"objects": [{"volume": "sponge", "mode": "mean"}], "size": [9, 9]})").value();
  EXPECT_EQ(one.view.mode, scene::Mode::mean);
  EXPECT_EQ(one.view, open(R"({"volume": "sponge", "mode": "mean", "size": [9, 9]})").value().view);
  const auto objects = open_objects(scene::parse_scene(R"({"volume": "sponge"})", "a").value(), options_);
  ASSERT_TRUE(objects.ok());
  EXPECT_EQ(objects.value().size(), 1u);
  const auto bad = open_objects(
      scene::parse_scene(R"({"objects": [{"volume": "sponge"}, {"volume": "none.gvx"}]})", "a").value());
  EXPECT_EQ(bad.error().message.rfind("objects[1]: none.gvx: ", 0), 0u) << bad.error().message;
}

TEST_F(Opening, warnings_go_to_who_listens) {
  const std::string function = R"("function": {"colors": [[0, 0, 0, 0], [1e-7, 1, 0, 0], [200, 1, 1, 1]],
                                                "opacities": [[0, 0], [1e-7, 0.5], [200, 0.9]]})";
  ASSERT_TRUE(open_ball(function).ok());
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("too close to tell apart"), std::string::npos) << warnings_[0];
}

}  // namespace
}  // namespace gvx::open
