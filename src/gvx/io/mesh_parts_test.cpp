#include "gvx/io/mesh_parts.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace gvx::io {
namespace {

class MeshParts : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + name, std::ios::binary) << text;
    return folder_ + name;
  }
  bool has(const std::vector<std::string>& files, const std::string& name) const {
    return std::find(files.begin(), files.end(), folder_ + name) != files.end();
  }

  std::string folder_ = testing::TempDir() + "gvx_mesh_parts/";
};

TEST_F(MeshParts, an_obj_names_its_materials) {
  const auto files =
      mesh_files(put("a.OBJ", "# mtllib none.mtl\r\nmtllib one two.mtl\r\nv 0 0 0\n mtllib\tlast.mtl\n"));
  EXPECT_TRUE(has(files, "a.OBJ"));
  EXPECT_TRUE(has(files, "one two.mtl"));
  EXPECT_TRUE(has(files, "two.mtl"));
  EXPECT_TRUE(has(files, "last.mtl"));
  EXPECT_FALSE(has(files, "none.mtl"));
  EXPECT_TRUE(has(mesh_files(put("cr.obj", "v 0 0 0\rmtllib last.mtl\r")), "last.mtl"));
}

TEST_F(MeshParts, a_gltf_names_its_buffers_and_pictures) {
  const std::string text =
      R"({"buffers": [{"uri": "a%20b.bin"}, {"uri": "data:application/octet-stream;base64,AA=="}, {}],
          "images": [{"uri": "tex/c.png"}]})";
  for (const bool binary : {false, true}) {
    std::string bytes = text;
    if (binary) {
      const auto word = [](std::uint32_t v) { return std::string(reinterpret_cast<char*>(&v), 4); };
      const auto size = static_cast<std::uint32_t>(text.size());
      bytes = "glTF" + word(2) + word(20 + size) + word(size) + "JSON" + text;
    }
    const auto files = mesh_files(put(binary ? "a.glb" : "a.gltf", bytes));
    EXPECT_EQ(files.size(), 3u);
    EXPECT_TRUE(has(files, "a b.bin"));
    EXPECT_TRUE(has(files, "tex/c.png"));
  }
}

TEST_F(MeshParts, what_cannot_be_read_names_none) {
  for (const char* name : {"none.obj", "none.gltf", "none.glb", "none.stl"}) {
    EXPECT_EQ(mesh_files(folder_ + name).size(), 1u);
  }
  EXPECT_EQ(mesh_files(put("bad.gltf", "{")).size(), 1u);
  EXPECT_EQ(mesh_files(put("list.gltf", R"({"buffers": 3, "images": [3, {"uri": 4}, {"uri": "%"}]})")).size(),
            2u);
}

}  // namespace
}  // namespace gvx::io
