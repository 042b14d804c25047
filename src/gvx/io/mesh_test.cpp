#include "gvx/io/mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "gvx/io/mesh_test_support.h"
#include "gvx/io/polygon.h"

namespace gvx::io {
namespace {

namespace fs = std::filesystem;

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

TEST(Mesh, the_axis_that_points_up_is_that_of_gltf_or_a_guess) {
  const Box3d near{{-1, -2, 1}, {3, 2, 5}}, map{{5e5, 5.4e6, 300}, {5e5 + 40, 5.4e6 + 30, 340}},
      south{{5e5, -5.4e6, 300}, {5e5 + 40, -5.4e6 + 30, 340}}, aside{{400, 0, 0}, {401, 1, 1}};
  for (const char* file : {"a.ply", "a.PLY.gz", "a.obj"}) {
    EXPECT_EQ(mesh_up(file, near).axis, UpAxis::y) << file;
    EXPECT_EQ(mesh_up(file, aside).axis, UpAxis::y) << file;
    EXPECT_EQ(mesh_up(file, map).axis, UpAxis::z) << file;
    EXPECT_EQ(mesh_up(file, south).axis, UpAxis::z) << file;
    EXPECT_TRUE(mesh_up(file, near).guessed) << file;
  }
  const Box3d on_y{{-1, 0, -1}, {1, 3, 1}}, on_z{{-1, -1, -0.001}, {1, 1, 3}};
  for (const char* file : {"a.ply", "a.obj", "a.stl"}) {
    EXPECT_EQ(mesh_up(file, on_y).axis, UpAxis::y) << file;
    EXPECT_EQ(mesh_up(file, on_z).axis, UpAxis::z) << file;
  }
  EXPECT_EQ(mesh_up("a.obj", on_z).why, "as it stands on z = 0");
  EXPECT_EQ(mesh_up("a.ply", {{0, 0, 0}, {1, 1, 1}}).axis, UpAxis::y);
  EXPECT_EQ(mesh_up("a.stl", {{0, 0, 0}, {1, 1, 1}}).axis, UpAxis::z);
  EXPECT_EQ(mesh_up("a.stl", near).axis, UpAxis::z);
  EXPECT_EQ(mesh_up("a.stl", near).why, "as in most STL files");
  for (const char* file : {"a.gltf", "a.glb"}) {
    EXPECT_EQ(mesh_up(file, map).axis, UpAxis::y) << file;
    EXPECT_FALSE(mesh_up(file, map).guessed) << file;
  }
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
        {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"},
        {"zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"},
        {"word.obj", "v 0 0 x\n"},
        {"flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"},
        {"short.stl", "facets"},
        {"count.stl", std::string(80, ' ') + std::string("\xff\xff\xff\xff", 4)},
        {"word.stl", "solid\nfacet\nvertex 0 0\n"},
        {"within.stl", "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"},
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

std::string with_line_ends(const std::string& text, const std::string& end) {
  std::string changed;
  for (const char c : text) changed += c == '\n' ? end : std::string(1, c);
  return changed;
}

/// A cube's corners and faces of four.
constexpr int kCubeFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

std::string cube_place(int corner, const Vec3d& origin, double size) {
  char text[200];
  std::snprintf(text, sizeof text, "%.17g %.17g %.17g", origin.x + size * (corner & 1),
                origin.y + size * (corner >> 1 & 1), origin.z + size * (corner >> 2));
  return text;
}

std::string cube_as_ply(const Vec3d& origin, double size) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) text += cube_place(i, origin, size) + "\n";
  for (const auto& f : kCubeFaces) {
    text += "4 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + " " +
            std::to_string(f[3]) + "\n";
  }
  return text;
}

std::string cube_as_obj(const Vec3d& origin, double size) {
  std::string text = "# a cube\no cube\n";
  for (int i = 0; i < 8; ++i) text.append("v ").append(cube_place(i, origin, size)).append("\n");
  for (const auto& f : kCubeFaces) {
    text += "f";
    for (const int v : f) text.append(1, ' ').append(std::to_string(v + 1));
    text += "\n";
  }
  return text;
}

std::string cube_as_stl(const Vec3d& origin, double size) {
  std::string text = "solid vertex of a cube\n";
  for (const auto& f : kCubeFaces) {
    for (const auto& t : {std::array{f[0], f[1], f[2]}, std::array{f[0], f[2], f[3]}}) {
      text += " facet normal 0 0 0\n  outer loop\n";
      for (const int v : t) text += "   vertex " + cube_place(v, origin, size) + "\n";
      text += "  endloop\n endfacet\n";
    }
  }
  return text + "endsolid\n";
}

TEST(Mesh, places_far_from_0_keep_their_digits_in_every_text) {
  const Vec3d origin(500000.125, 5400000.375, 312.5);
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"far.ply", cube_as_ply(origin, 0.1)},
                                   {"far.obj", cube_as_obj(origin, 0.1)},
                                   {"far.stl", cube_as_stl(origin, 0.1)}}) {
    const KeepingSink mesh = kept(written(name, text));
    EXPECT_EQ(mesh.bounds().minimum, origin) << name;
    EXPECT_LT(length(mesh.bounds().maximum - origin - Vec3d(0.1)), 1e-9) << name;
    EXPECT_EQ(mesh.triangles.size(), 12u) << name;
    EXPECT_NEAR(mesh.volume(), 0.001, 1e-9) << name;
    const auto held = read_mesh(written(name, text));
    ASSERT_TRUE(held.ok());
    EXPECT_EQ(held.value().triangles.size(), 12u);
    EXPECT_LT(length(held.value().bounds().maximum - mesh.bounds().maximum), 1e-8) << name;
  }
}

TEST(Mesh, lines_may_end_as_they_like) {
  for (const char* end : {"\n", "\r\n", "\r"}) {
    for (const auto& [name, text] : {std::pair<std::string, std::string>{"ends.ply", cube_as_ply({}, 1)},
                                     {"ends.obj", cube_as_obj({}, 1)},
                                     {"ends.stl", cube_as_stl({}, 1)}}) {
      const KeepingSink mesh = kept(written(name, with_line_ends(text, end)));
      EXPECT_EQ(mesh.triangles.size(), 12u) << name;
      EXPECT_NEAR(mesh.volume(), 1, 1e-12) << name;
    }
    // What comes behind the header may look like the end of a line.
    const std::string header = with_line_ends(
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\n"
        "property uchar z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n",
        end);
    const KeepingSink binary =
        kept(written("ends.ply", header + "\n\r\n\r\r\r\n\n\n" + std::string("\3\0\1\2", 4)));
    EXPECT_EQ(binary.places, (std::vector<Vec3d>{{10, 13, 10}, {13, 13, 13}, {10, 10, 10}}));
    EXPECT_EQ(binary.triangles.size(), 1u);
  }
}

/// Twice the area of triangles, above 0 where all of them go round as the polygon does.
double area_of(const std::vector<Vec3d>& corners, const std::vector<std::array<std::uint32_t, 3>>& cut,
               Vec3d normal) {
  double sum = 0;
  for (const auto& [a, b, c] : cut) {
    const double area = dot(cross(corners[b] - corners[a], corners[c] - corners[a]), normal);
    EXPECT_GE(area, -1e-9);
    sum += area;
  }
  return sum;
}

TEST(Polygon, is_cut_into_triangles_that_are_all_of_it) {
  struct Case {
    const char* name;
    std::vector<Vec3d> corners;
    double area;
  };
  std::vector<Case> cases = {
      {"square", {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, 4},
      {"L", {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}}, 5},
      {"U", {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}}, 7},
      {"arrow", {{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {1, 1, 0}}, 1},
      {"corners on its sides",
       {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}},
       4},
      {"window",  // a square hole, reached by a bridge there and back
       {{0, 0, 0},
        {4, 0, 0},
        {4, 4, 0},
        {0, 4, 0},
        {0, 0, 0},
        {1, 1, 0},
        {1, 3, 0},
        {3, 3, 0},
        {3, 1, 0},
        {1, 1, 0}},
       12}};
  Case comb{"comb", {}, 0};
  for (int i = 0; i < 200; ++i) {
    comb.corners.push_back({double(2 * i), 0, 0});
    comb.corners.push_back({double(2 * i + 1), 9, 0});
  }
  comb.corners.push_back({400, 0, 0});
  comb.corners.push_back({400, 10, 0});
  comb.corners.push_back({0, 10, 0});
  comb.area = 4000 - 200 * 9;
  cases.push_back(comb);
  for (const Case& c : cases) {
    const std::size_t count = c.corners.size();
    // From each corner on, both ways round, and seen from everywhere.
    for (std::size_t first = 0; first < count; first += 1 + count / 20) {
      for (const bool flipped : {false, true}) {
        for (int axis = 0; axis < 3; ++axis) {
          std::vector<Vec3d> corners;
          for (std::size_t i = 0; i < count; ++i) {
            const Vec3d p = c.corners[(first + (flipped ? count - i : i)) % count];
            corners.push_back(axis == 0   ? p
                              : axis == 1 ? Vec3d(p.z, p.x, p.y)
                                          : Vec3d(p.y, p.z + 0.3 * p.x, p.x));
          }
          std::vector<std::array<std::uint32_t, 3>> cut;
          cut_polygon(corners, cut);
          ASSERT_EQ(cut.size(), count - 2) << c.name;
          Vec3d around;
          for (std::size_t i = 2; i < count; ++i) {
            around = around + cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
          }
          ASSERT_NEAR(area_of(corners, cut, normalize(around)), length(around), 1e-6)
              << c.name << ' ' << first << ' ' << flipped << ' ' << axis;
          if (axis == 0) {
            ASSERT_NEAR(length(around), 2 * c.area, 1e-9) << c.name;
          }
          // Each side once, and what is within twice, there and back.
          std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
          for (const auto& t : cut) {
            for (std::size_t k = 0; k < 3; ++k) {
              ++sides[{t[k], t[(k + 1) % 3]}];
              --sides[{t[(k + 1) % 3], t[k]}];
            }
          }
          for (const auto& [side, times] : sides) {
            const bool of_polygon = side.second == (side.first + 1) % count;
            const bool back = side.first == (side.second + 1) % count;
            ASSERT_EQ(times, of_polygon ? 1 : back ? -1 : 0) << c.name;
          }
        }
      }
    }
  }
}

TEST(Polygon, of_any_corners_is_cut_in_a_bounded_time) {
  std::mt19937 random(11);
  for (const std::size_t count : {3u, 4u, 5u, 17u, 500u, 20000u}) {
    for (int kind = 0; kind < 5; ++kind) {
      std::vector<Vec3d> corners;
      for (std::size_t i = 0; i < count; ++i) {
        const auto any = [&] { return double(random() % 1000); };
        corners.push_back(kind == 0   ? Vec3d(any(), any(), any())
                          : kind == 1 ? Vec3d(any(), any(), 0)
                          : kind == 2 ? Vec3d(double(i), 0, 0)
                          : kind == 3 ? Vec3d(double(i % 2), double(i % 3), 0)
                                      : Vec3d(i % 7 == 0 ? NAN : 1, any(), 0));
      }
      std::vector<std::array<std::uint32_t, 3>> cut;
      cut_polygon(corners, cut);
      ASSERT_EQ(cut.size(), count - 2);
    }
  }
}

TEST(Mesh, concave_polygons_of_every_text_leave_their_notch_free) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n3 0 0\n3 3 0\n2 3 0\n2 1 0\n1 1 0\n1 3 0\n0 3 0\n8 0 1 2 3 4 5 6 7\n";
  const std::string obj =
      "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nf 1 2 3 4 5 6 7 8\n";
  for (const std::string& path : {written("u.ply", ply), written("u.obj", obj)}) {
    const KeepingSink mesh = kept(path);
    double area = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      area += length(cross(mesh.places[b] - mesh.places[a], mesh.places[c] - mesh.places[a])) / 2;
    }
    EXPECT_NEAR(area, 7, 1e-9) << path;
  }
}

TEST(Mesh, colours_of_faces_and_materials_are_theirs) {
  const std::string corners = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
  const KeepingSink ply = kept(written(
      "faces.ply",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nend_header\n" +
          corners + "3 0 1 2 255 0 0\n3 1 3 2 0 0 51\n"));
  EXPECT_EQ(ply.triangle_colors, (std::vector<Vec3f>{{1, 0, 0}, {0, 0, 0.2f}}));

  const std::string file =
      fs::path(written("faces.mtl", "newmtl a b\nKd 1 0.5 0\nmap_Kd wood.png\nnewmtl grey\nKd 0.25\n"))
          .filename();
  const KeepingSink obj = kept(
      written("faces.obj", "mtllib " + file +
                               "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nusemtl a b\n"
                               "f -4/1/1 -3//2 -2\nusemtl grey\nf 2 4 3\nusemtl none\nf 2 4 3\nl 1 2\n"));
  ASSERT_EQ(obj.triangle_colors.size(), 4u);
  EXPECT_EQ(obj.triangles[1], (Triangle{0, 1, 2}));
  EXPECT_EQ(obj.triangle_colors, (std::vector<Vec3f>{Vec3f(0.8f), {1, 0.5f, 0}, Vec3f(0.25f), Vec3f(0.8f)}));
  EXPECT_EQ(obj.unused, (std::set<std::string>{"textures", "lines"}));
  // Those of vertices come first.
  const KeepingSink both =
      kept(written("both.obj", "mtllib " + file +
                                   "\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nusemtl grey\nf 1 2 3\n"));
  EXPECT_EQ(both.vertex_colors, (std::vector<Vec3f>{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
  EXPECT_TRUE(both.triangle_colors.empty());

  // Binary STL: VisCAM's colour, and Magics' with one for the rest.
  const auto facet = [](std::uint16_t color) {
    return bytes_of(0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, color);
  };
  const std::string count = bytes_of(std::uint32_t{2});
  const KeepingSink viscam =
      kept(written("viscam.stl", std::string(80, ' ') + count + facet(0x8000 | 31 << 10) + facet(0)));
  EXPECT_EQ(viscam.triangle_colors, (std::vector<Vec3f>{{1, 0, 0}, Vec3f(0.8f)}));
  std::string header = "COLOR=" + std::string("\x33\x00\xff\xff", 4);
  header.resize(80, ' ');
  const KeepingSink magics = kept(written("magics.stl", header + count + facet(31) + facet(0x8000)));
  EXPECT_EQ(magics.triangle_colors, (std::vector<Vec3f>{{1, 0, 0}, {0.2f, 0, 1}}));
}

TEST(Mesh, obj_is_read_with_all_that_its_lines_may_hold) {
  const KeepingSink mesh =
      kept(written("lines.obj",
                   "f 1 2 \\\n 3 # a face before its vertices\nv 0 0 0 1.0\nv 1 0 0\nv 0 1 1.#INF\n"
                   "vn 0 0 1\nvp 1\ng f 1 2 3\nf -3 -2 -1\n"));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}}));
  EXPECT_FALSE(std::isfinite(mesh.places[2].z));
}

TEST(Mesh, ply_strips_are_cut_alternately) {
  const KeepingSink mesh = kept(written(
      "strips.ply",
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n1 1 0\n2 2 0\n8 0 1 2 3 -1 2 3 4\n"));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}}));
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
