#include "gvx/io/mesh_parts.h"

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

using nlohmann::json;

/// Names may hold spaces, and one line several names: all that it may mean.
void add_obj_parts(const std::string& path, std::vector<std::string>& files) {
  constexpr std::string_view kKeyword = "mtllib";
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    const std::string_view text = trimmed(line);
    if (!text.starts_with(kKeyword) || text.size() == kKeyword.size()) continue;
    const std::string_view names = trimmed(text.substr(kKeyword.size()));
    files.push_back(beside(path, names));
    for (const std::string_view name : words(names)) files.push_back(beside(path, name));
  }
}

/// The JSON of a .gltf, or of the first chunk of a .glb (glTF 2.0, section 4.4).
json read_gltf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char start[20] = {};
  file.read(start, sizeof start);
  if (file.gcount() == sizeof start && std::memcmp(start, "glTF", 4) == 0) {
    std::uint32_t bytes = 0;
    std::memcpy(&bytes, start + 12, sizeof bytes);
    std::string text;
    for (char c; text.size() < bytes && file.get(c);) text.push_back(c);
    return json::parse(text, nullptr, false);
  }
  file.clear();
  file.seekg(0);
  return json::parse(file, nullptr, false);
}

/// A URI's path: "%20" is a space.
std::string decoded(const std::string& uri) {
  std::string path;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto digit = [&](std::size_t at) {
      const std::string_view digits = "0123456789abcdef";
      const std::string small = lower_case(uri.substr(at, 1));
      return small.empty() ? std::string_view::npos : digits.find(small);
    };
    const std::size_t high = digit(i + 1), low = i + 2 < uri.size() ? digit(i + 2) : std::string_view::npos;
    if (uri[i] == '%' && high != std::string_view::npos && low != std::string_view::npos) {
      path.push_back(static_cast<char>(16 * high + low));
      i += 2;
    } else {
      path.push_back(uri[i]);
    }
  }
  return path;
}

void add_gltf_parts(const std::string& path, std::vector<std::string>& files) {
  const json document = read_gltf(path);
  if (!document.is_object()) return;
  for (const char* list : {"buffers", "images"}) {
    if (!document.contains(list) || !document[list].is_array()) continue;
    for (const json& part : document[list]) {
      if (!part.is_object() || !part.contains("uri") || !part["uri"].is_string()) continue;
      const std::string uri = part["uri"];
      if (!uri.starts_with("data:")) files.push_back(beside(path, decoded(uri)));
    }
  }
}

}  // namespace

std::vector<std::string> mesh_files(const std::string& path) {
  std::vector<std::string> files = {path};
  const std::string name = lower_case(path);
  if (name.ends_with(".obj")) add_obj_parts(path, files);
  if (name.ends_with(".gltf") || name.ends_with(".glb")) add_gltf_parts(path, files);
  return files;
}

}  // namespace gvx::io
