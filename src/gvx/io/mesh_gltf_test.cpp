// glTF: what its accessors, nodes and materials say, and files that say what cannot be.

#include <array>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "gvx/io/mesh_test_support.h"

namespace gvx::io {
namespace {

using nlohmann::json;

std::string base64(const std::string& bytes) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= std::min<std::size_t>(bytes.size() - i, 3) ? digits[bits >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

/// A scene of one mesh of one triangle list that tests change.
class Gltf {
 public:
  Gltf() {
    root = json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                           "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {}}]}],
                           "accessors": [], "bufferViews": []})");
  }

  json& primitive() { return root["meshes"][0]["primitives"][0]; }

  /// Puts it in a view of its own; returns its index.
  int add(const std::string& bytes, int component_type, const char* type, std::size_t count,
          bool normalized = false, std::size_t stride = 0) {
    while (buffer.size() % 4 != 0) buffer += '\0';
    json view = {{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}};
    if (stride > 0) view["byteStride"] = stride;
    root["bufferViews"].push_back(view);
    buffer += bytes;
    json accessor = {{"bufferView", root["bufferViews"].size() - 1},
                     {"componentType", component_type},
                     {"type", type},
                     {"count", count}};
    if (normalized) accessor["normalized"] = true;
    root["accessors"].push_back(accessor);
    return static_cast<int>(root["accessors"].size()) - 1;
  }

  /// A triangle of floats.
  void add_triangle() {
    primitive()["attributes"]["POSITION"] =
        add(bytes_of(0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f), 5126, "VEC3", 3);
  }

  std::string write(const std::string& name = "test.gltf") {
    json whole = root;
    if (!whole.contains("buffers")) {
      whole["buffers"] = {
          {{"byteLength", buffer.size()}, {"uri", "data:application/octet-stream;base64," + base64(buffer)}}};
    }
    return written(name, whole.dump());
  }

  std::string write_glb(const std::string& name = "test.glb") {
    json whole = root;
    whole["buffers"] = {{{"byteLength", buffer.size()}}};
    std::string text = whole.dump();
    while (text.size() % 4 != 0) text += ' ';
    while (buffer.size() % 4 != 0) buffer += '\0';
    return written(
        name, "glTF" +
                  bytes_of(std::uint32_t{2}, static_cast<std::uint32_t>(28 + text.size() + buffer.size()),
                           static_cast<std::uint32_t>(text.size())) +
                  "JSON" + text + bytes_of(static_cast<std::uint32_t>(buffer.size())) +
                  std::string("BIN\0", 4) + buffer);
  }

  json root;
  std::string buffer;
};

TEST(Gltf, is_the_same_with_its_buffer_within_beside_or_in_a_glb) {
  Gltf file;
  file.add_triangle();
  file.primitive()["indices"] =
      file.add(bytes_of(std::uint8_t{2}, std::uint8_t{0}, std::uint8_t{1}), 5121, "SCALAR", 3);
  const std::vector<Vec3d> places = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::string within = file.write(), glb = file.write_glb();
  written("beside it.bin", file.buffer);
  file.root["buffers"] = {{{"byteLength", file.buffer.size()}, {"uri", "gvx_mesh_beside%20it.bin"}}};
  for (const std::string& path : {within, glb, file.write("beside.gltf")}) {
    const KeepingSink mesh = kept(path);
    EXPECT_EQ(mesh.places, places) << path;
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{2, 0, 1}})) << path;
    EXPECT_TRUE(mesh.vertex_colors.empty());
  }
}

TEST(Gltf, quantized_places_are_what_they_say) {
  Gltf file;
  file.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  file.root["extensionsUsed"] = {"KHR_mesh_quantization"};
  // As a stride of eight bytes has it, and as shares of 1 that the node takes back.
  using I16 = std::int16_t;
  file.primitive()["attributes"]["POSITION"] =
      file.add(bytes_of(I16{0}, I16{0}, I16{0}, I16{9}, I16{16000}, I16{0}, I16{0}, I16{9}, I16{0},
                        I16{-16000}, I16{7}, I16{9}),
               5122, "VEC3", 3, false, 8);
  EXPECT_EQ(kept(file.write()).places, (std::vector<Vec3d>{{0, 0, 0}, {16000, 0, 0}, {0, -16000, 7}}));

  Gltf shares;
  shares.primitive()["attributes"]["POSITION"] =
      shares.add(bytes_of(std::int8_t{-128}, std::int8_t{-127}, std::int8_t{127}, std::int8_t{0},
                          std::int8_t{0}, std::int8_t{0}, std::int8_t{127}, std::int8_t{0}, std::int8_t{0}),
                 5120, "VEC3", 3, true);
  shares.root["nodes"][0]["scale"] = {2, 4, 8};
  EXPECT_EQ(kept(shares.write()).places, (std::vector<Vec3d>{{-2, -4, 8}, {0, 0, 0}, {2, 0, 0}}));
  Gltf words;
  words.primitive()["attributes"]["POSITION"] = words.add(
      bytes_of(std::uint16_t{65535}, std::uint16_t{0}, std::uint16_t{13107}), 5123, "VEC3", 1, true);
  EXPECT_EQ(kept(words.write()).places, (std::vector<Vec3d>{{1, 0, 0.2}}));
}

TEST(Gltf, what_a_file_requires_and_is_not_known_is_an_error_that_names_it) {
  for (const char* name :
       {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing", "ANY_other"}) {
    Gltf file;
    file.add_triangle();
    file.root["extensionsUsed"] = {name};
    EXPECT_EQ(kept(file.write()).triangles.size(), 1u) << name;
    file.root["extensionsRequired"] = {name};
    EXPECT_NE(error_of(file.write()).find(name), std::string::npos) << error_of(file.write());
  }
  Gltf file;
  file.add_triangle();
  file.root["extensionsRequired"] = {"KHR_materials_unlit", "KHR_texture_transform"};
  EXPECT_EQ(kept(file.write()).triangles.size(), 1u);
  // Not required by name, but nothing else is there.
  file.root.erase("extensionsRequired");
  file.root["accessors"][0].erase("bufferView");
  file.primitive()["extensions"]["KHR_draco_mesh_compression"] = json::object();
  EXPECT_NE(error_of(file.write()).find("KHR_draco_mesh_compression"), std::string::npos);
}

TEST(Gltf, nodes_place_parts_in_doubles) {
  Gltf file;
  file.add_triangle();
  file.root["scenes"][0]["nodes"] = {0};
  file.root["nodes"] = json::parse(R"([
    {"translation": [500000.125, 5400000.375, 312.5], "children": [1, 2]},
    {"mesh": 0, "scale": [0.1, 0.1, 0.1]},
    {"mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 1], "children": [3]},
    {"mesh": 0, "rotation": [0, 0, 0.70710678118654757, 0.70710678118654757], "scale": [-1, 1, 1]}])");
  const KeepingSink mesh = kept(file.write());
  ASSERT_EQ(mesh.places.size(), 9u);
  const Vec3d origin(500000.125, 5400000.375, 312.5);
  const auto expect_near = [&](std::size_t v, Vec3d offset) {
    EXPECT_LT(length(mesh.places[v] - origin - offset), 1e-9) << v;
  };
  expect_near(0, {0, 0, 0}), expect_near(1, {0.1, 0, 0}), expect_near(2, {0, 0.1, 0});
  expect_near(3, {0, 0, 2}), expect_near(4, {0, 1, 2}), expect_near(5, {-1, 0, 2});
  // x goes to -x, a quarter turn to -y, another to x.
  expect_near(7, {1, 0, 2}), expect_near(8, {0, -1, 2});
  // A mirror turns triangles round: front stays front.
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}, {7, 6, 8}}));
}

TEST(Gltf, strips_and_fans_are_triangles_and_points_and_lines_are_named) {
  Gltf file;
  file.primitive()["attributes"]["POSITION"] = file.add(std::string(5 * 12, '\0'), 5126, "VEC3", 5);
  const auto triangles_of = [&](int mode) {
    file.primitive()["mode"] = mode;
    return kept(file.write()).triangles;
  };
  EXPECT_EQ(triangles_of(5), (std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}}));
  EXPECT_EQ(triangles_of(6), (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
  EXPECT_EQ(triangles_of(4), (std::vector<Triangle>{{0, 1, 2}}));
  for (int mode = 0; mode < 4; ++mode) {
    file.primitive()["mode"] = mode;
    EXPECT_EQ(kept(file.write()).unused, (std::set<std::string>{mode == 0 ? "points" : "lines"}));
  }
  file.primitive()["mode"] = 7;
  EXPECT_NE(error_of(file.write()).find("mode 7"), std::string::npos);
}

TEST(Gltf, colours_are_linear_and_become_what_is_displayed) {
  Gltf file;
  file.add_triangle();
  using U8 = std::uint8_t;
  const U8 half = 128, all = 255, none = 0;
  file.primitive()["attributes"]["COLOR_0"] = file.add(
      bytes_of(half, half, half, all, all, none, none, all, none, all, half, none), 5121, "VEC4", 3, true);
  const auto bytes = [&] {
    std::vector<std::array<long, 3>> found;
    for (const Vec3f& c : kept(file.write()).vertex_colors) {
      found.push_back({std::lround(255 * c.x), std::lround(255 * c.y), std::lround(255 * c.z)});
    }
    return found;
  };
  EXPECT_EQ(bytes(), (std::vector<std::array<long, 3>>{{188, 188, 188}, {255, 0, 0}, {0, 255, 188}}));
  // The material's colour dyes them, and is the colour where there are none.
  file.root["materials"] = json::parse(R"([{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 0, 1]}}, {},
                                           {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
  file.primitive()["material"] = 0;
  EXPECT_EQ(bytes(), (std::vector<std::array<long, 3>>{{137, 188, 0}, {188, 0, 0}, {0, 255, 0}}));
  file.primitive()["attributes"].erase("COLOR_0");
  EXPECT_EQ(bytes(), (std::vector<std::array<long, 3>>(3, {188, 255, 0})));
  file.primitive()["material"] = 1;
  EXPECT_EQ(bytes(), (std::vector<std::array<long, 3>>(3, {255, 255, 255})));
  // What a texture would say is not known.
  file.primitive()["material"] = 2;
  EXPECT_TRUE(bytes().empty());
}

TEST(Gltf, sparse_accessors_change_some_elements) {
  Gltf file;
  file.add_triangle();
  const int indices = file.add(bytes_of(std::uint16_t{2}), 5123, "SCALAR", 1);
  const int values = file.add(bytes_of(7.f, 8.f, 9.f), 5126, "VEC3", 1);
  file.root["accessors"][0]["sparse"] = {{"count", 1},
                                         {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                                         {"values", {{"bufferView", values}}}};
  EXPECT_EQ(kept(file.write()).places, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {7, 8, 9}}));
  file.root["accessors"][0].erase("bufferView");
  EXPECT_EQ(kept(file.write()).places, (std::vector<Vec3d>{{0, 0, 0}, {0, 0, 0}, {7, 8, 9}}));
  file.root["accessors"][0]["count"] = 2;
  EXPECT_NE(error_of(file.write()).find("sparse"), std::string::npos);
}

TEST(Gltf, what_is_not_used_is_named) {
  Gltf file;
  file.add_triangle();
  for (const char* field : {"textures", "skins", "animations"}) file.root[field] = {json::object()};
  file.primitive()["attributes"]["TEXCOORD_0"] = 0;
  file.primitive()["targets"] = {json::object()};
  file.root["materials"] = {{{"alphaMode", "BLEND"}}};
  file.primitive()["material"] = 0;
  EXPECT_EQ(kept(file.write()).unused,
            (std::set<std::string>{"textures", "skins", "animations", "texture coordinates", "morph targets",
                                   "transparency of materials"}));
}

TEST(Gltf, what_cannot_be_is_an_error_in_one_line) {
  const auto changed = [](const std::function<void(json&)>& change) {
    Gltf file;
    file.add_triangle();
    file.primitive()["indices"] =
        file.add(bytes_of(std::uint16_t{0}, std::uint16_t{1}, std::uint16_t{2}), 5123, "SCALAR", 3);
    file.root["buffers"] = {
        {{"byteLength", file.buffer.size()}, {"uri", "data:;base64," + base64(file.buffer)}}};
    change(file.root);
    return error_of(file.write());
  };
  EXPECT_EQ(changed([](json&) {}), "none");
  const std::vector<std::pair<const char*, std::function<void(json&)>>> cases = {
      {"asset.version", [](json& j) { j["asset"]["version"] = "1.0"; }},
      {"asset.version", [](json& j) { j.erase("asset"); }},
      {"scenes", [](json& j) { j["scene"] = 9; }},
      {"scene", [](json& j) { j["scene"] = -1; }},
      {"nodes", [](json& j) { j["scenes"][0]["nodes"] = {7}; }},
      {"nodes", [](json& j) { j["scenes"][0]["nodes"] = {"a"}; }},
      {"nodes[0]", [](json& j) { j["nodes"][0]["children"] = {0}; }},
      {"nodes[0]",
       [](json& j) {
         j["scenes"][0]["nodes"] = {0, 0};
       }},
      {"meshes", [](json& j) { j["nodes"][0]["mesh"] = 1; }},
      {"matrix",
       [](json& j) {
         j["nodes"][0]["matrix"] = {1, 2};
       }},
      {"translation",
       [](json& j) {
         j["nodes"][0]["translation"] = {1, 2, "x"};
       }},
      {"primitive", [](json& j) { j["meshes"][0]["primitives"][0] = 1; }},
      {"attributes", [](json& j) { j["meshes"][0]["primitives"][0].erase("attributes"); }},
      {"accessors", [](json& j) { j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 5; }},
      {"POSITION", [](json& j) { j["accessors"][0]["type"] = "VEC2"; }},
      {"type", [](json& j) { j["accessors"][0]["type"] = "VEC9"; }},
      {"componentType", [](json& j) { j["accessors"][0]["componentType"] = 5124; }},
      {"count", [](json& j) { j["accessors"][0].erase("count"); }},
      {"reaches beyond", [](json& j) { j["accessors"][0]["count"] = 4; }},
      {"reaches beyond", [](json& j) { j["accessors"][0]["count"] = 4000000000000000; }},
      {"reaches beyond", [](json& j) { j["accessors"][0]["byteOffset"] = 4; }},
      {"too many",
       [](json& j) { j["accessors"][0].erase("bufferView"), j["accessors"][0]["count"] = 4000000000; }},
      {"byteStride", [](json& j) { j["bufferViews"][0]["byteStride"] = 4; }},
      {"reaches beyond", [](json& j) { j["bufferViews"][0]["byteLength"] = 4000; }},
      {"reaches beyond", [](json& j) { j["bufferViews"][0]["byteOffset"] = 4503599627370495; }},
      {"byteOffset", [](json& j) { j["bufferViews"][0]["byteOffset"] = 1e300; }},
      {"buffer", [](json& j) { j["bufferViews"][0]["buffer"] = 3; }},
      {"byteLength", [](json& j) { j["buffers"][0]["byteLength"] = 4000; }},
      {"base64", [](json& j) { j["buffers"][0]["uri"] = "data:;base64,~~~~"; }},
      {"leaves the folder", [](json& j) { j["buffers"][0]["uri"] = "../../etc/passwd"; }},
      {"leaves the folder", [](json& j) { j["buffers"][0]["uri"] = "%2e%2e/x"; }},
      {"leaves the folder", [](json& j) { j["buffers"][0]["uri"] = "/etc/passwd"; }},
      {"leaves the folder", [](json& j) { j["buffers"][0]["uri"] = "http://example.com/x.bin"; }},
      {"cannot open", [](json& j) { j["buffers"][0]["uri"] = "nowhere.bin"; }},
  };
  for (const auto& [part, change] : cases) {
    const std::string message = changed(change);
    EXPECT_NE(message.find(part), std::string::npos) << part << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
  // Vertices that are not there are left to the sink.
  Gltf file;
  file.add_triangle();
  file.primitive()["indices"] =
      file.add(bytes_of(std::uint32_t{0}, std::uint32_t{1}, std::uint32_t{3}), 5125, "SCALAR", 3);
  EXPECT_EQ(kept(file.write()).triangles, (std::vector<Triangle>{{0, 1, UINT32_MAX}}));
  // Cut off anywhere.
  const std::string path = file.write_glb();
  std::ifstream in(path, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_NE(error_of(written("cut.glb", whole.substr(0, length))), "none") << length;
  }
}

}  // namespace
}  // namespace gvx::io
