#include "gvx/io/mesh_parts.h"

#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "gvx/io/byte_stream.h"
#include "gvx/io/gltf_file.h"
#include "gvx/io/header_text.h"
#include "gvx/io/text_scanner.h"

namespace gvx::io {
namespace {

using nlohmann::json;

/// Names may hold spaces, and one line several names: all that it may mean.
void add_obj_parts(const std::string& path, std::vector<std::string>& files) {
  constexpr std::string_view kKeyword = "mtllib";
  constexpr std::size_t kLongestLine = 1 << 26;
  auto stream = open_byte_stream(path, Encoding::raw, {}, SampleType::u8);
  if (!stream.ok()) return;
  TextScanner in(std::move(stream).value());
  std::string line;
  while (true) {
    const Result<bool> more = in.line(line, kLongestLine);
    if (!more.ok() || !more.value()) return;
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

void add_gltf_parts(const std::string& path, std::vector<std::string>& files) {
  const json document = read_gltf(path);
  if (!document.is_object()) return;
  for (const char* list : {"buffers", "images"}) {
    if (!document.contains(list) || !document[list].is_array()) continue;
    for (const json& part : document[list]) {
      if (!part.is_object() || !part.contains("uri") || !part["uri"].is_string()) continue;
      const std::string uri = part["uri"];
      if (!uri.starts_with("data:")) files.push_back(beside(path, uri_path(uri)));
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
