#include "gvx/io/mesh.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace gvx::io {
namespace {

namespace fs = std::filesystem;

std::string written(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + "gvx_mesh_" + name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string ascii_ply(std::uint64_t vertices, std::uint64_t faces) {
  return "ply\nformat ascii 1.0\ncomment of ours\nelement vertex " + std::to_string(vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

TEST(Mesh, ply_is_the_same_as_text_and_in_both_byte_orders) {
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    std::string text = std::string("ply\nformat ") + format +
                       " 1.0\nelement extra 1\nproperty list uchar short numbers\nelement vertex 3\n"
                       "property double x\nproperty double y\nproperty double z\nelement face 1\n"
                       "property list uchar uint vertex_index\nproperty float area\nend_header\n";
    const bool big = std::string(format) == "binary_big_endian";
    const auto put = [&](auto value, const char* written_out) {
      if (format[0] == 'a') {
        text += std::string(written_out) + "\n";
        return;
      }
      std::array<char, sizeof(value)> bytes{};
      std::memcpy(bytes.data(), &value, sizeof(value));
      if (big) std::reverse(bytes.begin(), bytes.end());
      text.append(bytes.data(), bytes.size());
    };
    put(std::uint8_t{2}, "2"), put(std::int16_t{7}, "7"), put(std::int16_t{-9}, "-9");
    put(1.5, "1.5"), put(0.0, "0"), put(0.0, "0");
    put(0.0, "0"), put(-2.25, "-2.25"), put(0.0, "0");
    put(0.0, "0"), put(0.0, "0"), put(1e3, "1e3");
    put(std::uint8_t{3}, "3"), put(0u, "0"), put(1u, "1"), put(2u, "2"), put(0.5f, "0.5");
    const auto mesh = read_mesh(written(std::string(format) + ".ply", text));
    ASSERT_TRUE(mesh.ok()) << mesh.error().message;
    EXPECT_EQ(mesh.value().vertices, (std::vector<Vec3f>{{1.5f, 0, 0}, {0, -2.25f, 0}, {0, 0, 1000}}));
    ASSERT_EQ(mesh.value().triangles.size(), 1u);
    EXPECT_EQ(mesh.value().triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
  }
}

TEST(Mesh, keeps_places_colors_and_connections_and_cuts_polygons) {
  const auto mesh = read_mesh(written("square.ply",
                                      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                                      "property float y\nproperty float z\nproperty uchar red\n"
                                      "property uchar green\nproperty uchar blue\nelement face 1\n"
                                      "property list uchar int vertex_indices\nend_header\n"
                                      "0 0 0 255 0 0\n2 0 0 255 0 0\n2 3 0 255 0 0\n0 3 5 0 0 255\n"
                                      "4 0 1 2 3\n"));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().triangles.size(), 2u);
  EXPECT_EQ(mesh.value().vertices.size(), 4u);
  ASSERT_EQ(mesh.value().colors.size(), 4u);
  const Box3d box = mesh.value().bounds();
  EXPECT_EQ(box.minimum, Vec3d(0, 0, 0));
  EXPECT_EQ(box.maximum, Vec3d(2, 3, 5));
  for (std::size_t v = 0; v < 4; ++v) {
    const bool blue = mesh.value().vertices[v].z > 0;
    EXPECT_EQ(mesh.value().colors[v], blue ? Vec3f(0, 0, 1) : Vec3f(1, 0, 0));
  }
}

TEST(Mesh, triangles_that_cover_nothing_are_dropped_and_counted) {
  MeshReport report;
  const auto mesh = read_mesh(written("flat.ply", ascii_ply(5, 3) + "0 0 0\n1 0 0\n0 1 0\n2 0 0\n3 0 0\n"
                                                                    "3 0 1 2\n3 0 1 3\n3 0 3 4\n"),
                              &report);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh.value().triangles.size(), 1u);
  EXPECT_EQ(mesh.value().vertices.size(), 3u);
  EXPECT_EQ(report.dropped, 2u);
}

TEST(Mesh, what_is_no_mesh_is_an_error_that_names_the_file) {
  for (const auto& [name, text] :
       {std::pair<std::string, std::string>{"empty.ply", ""},
        {"header.ply", "ply\nformat ascii 1.0\nelement vertex 9\n"},
        {"points.ply",
         "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         "property float z\nend_header\n0 0 0\n"},
        {"noise.glb", "glTF\2\0\0\0garbage"},
        {"nothing.obj", "# nothing\n"},
        {"count.ply", ascii_ply(4000000000, 1) + "0 0 0\n"},
        {"word.ply", ascii_ply(3, 1) + "0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n"},
        {"short.ply", ascii_ply(3, 1) + "0 0 0\n1 0 0\n0 1 0\n3 0 1"},
        {"index.ply", ascii_ply(3, 1) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"}}) {
    const std::string path = written(name, text);
    const auto mesh = read_mesh(path);
    ASSERT_FALSE(mesh.ok()) << name;
    EXPECT_NE(mesh.error().message.find(path), std::string::npos) << mesh.error().message;
    EXPECT_EQ(mesh.error().message.find('\n'), std::string::npos);
  }
  EXPECT_FALSE(read_mesh("/nowhere/at/all.ply").ok());
  EXPECT_FALSE(read_mesh(written("text.txt", "hello")).ok());
}

TEST(Mesh, files_of_other_projects_give_a_sound_mesh_or_an_error) {
  const char* data = std::getenv("GVX_TEST_DATA");
  if (data == nullptr || *data == '\0') GTEST_SKIP() << "GVX_TEST_DATA is not set";
  int read = 0, refused = 0;
  for (const char* folder : {"meshes", "malformed"}) {
    if (!fs::exists(fs::path(data) / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(data) / folder)) {
      const std::string path = entry.path().string();
      if (!entry.is_regular_file() || !is_mesh_name(path)) continue;
      const auto mesh = read_mesh(path);
      if (!mesh.ok()) {
        ++refused;
        EXPECT_NE(mesh.error().message.find(path), std::string::npos);
        continue;
      }
      ++read;
      for (const auto& triangle : mesh.value().triangles) {
        for (const std::uint32_t v : triangle) ASSERT_LT(v, mesh.value().vertices.size()) << path;
      }
      const Box3d box = mesh.value().bounds();
      EXPECT_TRUE(std::isfinite(length(box.maximum - box.minimum))) << path;
    }
  }
  EXPECT_GT(read, 50);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace gvx::io
