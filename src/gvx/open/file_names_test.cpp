#include "gvx/open/file_names.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace gvx::open {
namespace {

namespace fs = std::filesystem;

class FileNames : public testing::Test {
 protected:
  FileNames() {
    fs::create_directories(folder_ / "below");
    std::ofstream(folder_ / "below/map.json") << "[]";
    std::ofstream(folder_ / "below/mesh.ply") << "ply\n";
  }
  ~FileNames() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  const fs::path folder_ = fs::path(testing::TempDir()) / "gvx_file_names";
};

TEST_F(FileNames, a_file_begins_behind_what_is_made_of_it) {
  const auto file = [](const std::string& name) { return name.substr(file_position(name)); };
  EXPECT_EQ(file("head.gvx"), "head.gvx");
  EXPECT_EQ(file("repeat:8:amplify:distance:a/b.ply"), "a/b.ply");
  EXPECT_EQ(file("hypertexture:a.ply"), "a.ply");
  EXPECT_EQ(file("s3://bucket/a.gvx"), "s3://bucket/a.gvx");
}

TEST_F(FileNames, are_told_from_the_folder_of_the_scene_and_back) {
  scene::SceneFile scene;
  scene.volume = "distance:mesh.ply";
  scene.functions = {{.from = "map.json"}, {.from = "ct-bone"}};
  resolve_names(scene, path("below/scene.json"));
  EXPECT_EQ(scene.volume, "distance:" + path("below/mesh.ply"));
  EXPECT_EQ(scene.functions[0].from, path("below/map.json"));
  EXPECT_EQ(scene.functions[1].from, "ct-bone");
  const std::vector<std::string> files = files_of_scene(scene);
  for (const char* name : {"below/map.json", "below/mesh.ply"}) {
    EXPECT_EQ(std::count(files.begin(), files.end(), path(name)), 1) << name;
  }
  relate_names(scene, path("scene.json"));
  EXPECT_EQ(scene.volume, "distance:below/mesh.ply");
  scene.volume = "sponge";
  resolve_names(scene, path("below/scene.json"));
  EXPECT_EQ(scene.volume, "sponge");
}

}  // namespace
}  // namespace gvx::open
