#include "gvx/scene/scene_file.h"

#include <algorithm>
#include <set>

#include "gvx/core/text_file.h"
#include "gvx/scene/json_fields.h"
#include "gvx/scene/scene_fields.h"

namespace gvx::scene {
namespace {

using Json = nlohmann::json;
using WrittenJson = nlohmann::ordered_json;

/// "line 3, column 7" of the byte that a parser counts from 1.
std::string line_and_column(const std::string& text, std::size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte > 0 ? byte - 1 : 0, text.size()));
  const auto line_start = std::find(std::make_reverse_iterator(end), text.rend(), '\n').base();
  return "line " + std::to_string(1 + std::count(text.begin(), end, '\n')) + ", column " +
         std::to_string(1 + (end - line_start));
}

/// An error also where one object has two fields of one name, of which the library would drop the first.
Result<Json> parse_json(const std::string& text) {
  std::vector<std::set<std::string>> open_objects;
  std::optional<std::string> twice;
  const auto watch = [&](int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) open_objects.emplace_back();
    if (event == Json::parse_event_t::object_end) open_objects.pop_back();
    if (event == Json::parse_event_t::key && !open_objects.back().insert(parsed.get<std::string>()).second &&
        !twice) {
      twice = describe(parsed);
    }
    return true;
  };
  try {
    Json document = Json::parse(text, watch, true, true);
    if (twice) return Error{"expected each field once, found " + *twice + " twice in one object"};
    return document;
  } catch (const Json::parse_error& error) {
    return Error{"not JSON at " + line_and_column(text, error.byte)};
  } catch (const Json::exception&) {
    return Error{"expected numbers up to 1e308, found a greater one"};
  }
}

/// Lists of numbers on one line, all else a line each.
void write(const WrittenJson& value, std::string& text, const std::string& indent) {
  const auto nested = [](const WrittenJson& v) { return v.is_structured(); };
  if (!value.is_structured() || value.empty() ||
      (value.is_array() && std::none_of(value.begin(), value.end(), nested))) {
    text += value.dump(-1, ' ', false, WrittenJson::error_handler_t::replace);
    return;
  }
  const std::string inner = indent + "  ";
  const char* separator = "\n";
  text += value.is_array() ? '[' : '{';
  for (const auto& [key, field] : value.items()) {
    text += separator + inner;
    if (value.is_object()) text += '"' + key + "\": ";
    write(field, text, inner);
    separator = ",\n";
  }
  text += '\n' + indent + (value.is_array() ? ']' : '}');
}

}  // namespace

Result<SceneFile> parse_scene(const std::string& text, const std::string& name) {
  const auto in_file = [&](const Error& error) { return Error{name + ": " + error.message}; };
  const auto document = parse_json(text);
  if (!document.ok()) return in_file(document.error());
  SceneFile scene;
  const Status read = read_over(document.value(), scene);
  if (!read.ok()) return in_file(read.error());
  return scene;
}

Result<SceneFile> read_scene(const std::string& path) {
  GVX_ASSIGN(const std::string text, read_text_file(path, "a scene file"));
  return parse_scene(text, path);
}

std::string to_json(const SceneFile& scene) {
  std::string text;
  write(to_document(scene), text, "");
  return text + "\n";
}

}  // namespace gvx::scene
