#include "field_flags.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands.h"
#include "gvx/io/sample_type.h"
#include "gvx/open/open_volume.h"
#include "units.h"

namespace gvx::app {
namespace {

using scene::FieldDescription;
using scene::FieldForm;

/// Types of samples have more names than the one in a scene file.
constexpr std::string_view kSampleType = "raw.dtype";

/// "FLOAT:FLOAT in [0 - 100]", as CLI11 describes a check of a range, where that is short. The range itself
/// is checked with those of scene files.
std::string type_text(const std::string& kind, const scene::NumberRange& range) {
  if (range.open || !(range.most <= 1e5) || !(range.least >= 0)) return kind;
  char text[64];
  std::snprintf(text, sizeof(text), " in [%g - %g]", range.least, range.most);
  return kind + ":" + kind + text;
}

std::string pointer_of(const std::string& path) {
  std::string pointer = "/" + path;
  std::replace(pointer.begin(), pointer.end(), '.', '/');
  return pointer;
}

/// The flags that say what a field holds that has none of its own name.
const std::pair<std::string_view, const char*> kOtherFlags[] = {{"functions", "--tf"},
                                                                {"labels", "--labels"},
                                                                {"lighting.lights", "--light"},
                                                                {"cameraPath", "--key-frame"},
                                                                {"camera", "--camera"}};

/// The flag of the field at a place such as "functions[0].window[1]", and what of it is meant; empty: none.
std::string flag_at(const std::string& place) {
  for (const FieldDescription& field : scene::scene_fields()) {
    if (field.flag_name().empty() || place.substr(0, place.find('[')) != field.path) continue;
    const bool size = field.form == FieldForm::size;
    return field.flag_name() + (!size ? "" : place.ends_with("[0]") ? ": width" : ": height");
  }
  for (const auto& [path, flag] : kOtherFlags) {
    if (!place.starts_with(path)) continue;
    const std::size_t part = place.rfind('.');
    return flag + (part != std::string::npos && part >= path.size() ? ": " + place.substr(part + 1) : "");
  }
  return {};
}

}  // namespace

void FieldFlags::add_to(CLI::App& command, const Choice& chosen) {
  for (const FieldDescription& field : scene::scene_fields()) {
    if (field.flag.names == nullptr || (chosen && !chosen(field))) continue;
    Flag& flag = flags_.emplace_back(Flag{field});
    const auto add = [&](auto& value) {
      flag.option = command.add_option(field.flag.names, value, field.flag.help);
    };
    switch (field.form) {
      case FieldForm::number:
        add(flag.number);
        flag.option->type_name(type_text("FLOAT", field.range));
        break;
      case FieldForm::whole:
        add(flag.whole);
        flag.option->type_name(type_text("UINT", field.range));
        break;
      case FieldForm::yes_or_no:
        flag.option = command.add_flag(field.flag.names, flag.yes, field.flag.help);
        break;
      default:
        add(flag.text);
        flag.option->check(not_empty());
    }
    if (!field.choices.empty() && field.path != kSampleType) {
      flag.option->check(CLI::IsMember(std::vector<std::string>(field.choices.begin(), field.choices.end())));
    }
    if (*field.flag.group != 0) flag.option->group(field.flag.group);
  }
}

bool FieldFlags::given(const Choice& chosen) const {
  return std::any_of(flags_.begin(), flags_.end(),
                     [&](const Flag& flag) { return flag.option->count() > 0 && chosen(flag.field); });
}

bool FieldFlags::given(std::string_view path) const {
  return given([&](const FieldDescription& field) { return field.path == path; });
}

Result<nlohmann::json> FieldFlags::value_of(const Flag& flag) {
  const FieldDescription& field = flag.field;
  const auto bad = [&](const std::string& expected) {
    return Error{field.flag_name() + ": '" + flag.text + "' is not " + expected};
  };
  if (field.path == kSampleType) {
    const auto type = io::parse_sample_type(flag.text);
    if (!type) return bad(std::string("one of ") + io::kSampleTypeNames);
    return nlohmann::json(io::sample_name(*type));
  }
  if (field.form == FieldForm::number) return nlohmann::json(flag.number);
  if (field.form == FieldForm::whole) return nlohmann::json(flag.whole);
  if (field.form == FieldForm::yes_or_no) return nlohmann::json(flag.yes);
  if (field.form == FieldForm::size) {
    const auto size = parse_size(flag.text);
    if (!size) return bad(field.flag.expected);
    return nlohmann::json{size->width, size->height};
  }
  if (field.form != FieldForm::numbers) return nlohmann::json(flag.text);
  const auto numbers = parse_list(flag.text);
  const auto is_whole = [&](double v) { return !field.range.whole || field.range.contains(v); };
  if (!numbers || numbers->size() != field.count ||
      !std::all_of(numbers->begin(), numbers->end(), is_whole)) {
    return bad(field.flag.expected);
  }
  return nlohmann::json(*numbers);
}

Status FieldFlags::apply(scene::SceneFile& scene) const {
  nlohmann::json document = nlohmann::json::object();
  for (const Flag& flag : flags_) {
    if (flag.option->count() == 0) continue;
    GVX_ASSIGN(document[nlohmann::json::json_pointer(pointer_of(flag.field.path))], value_of(flag));
  }
  const Status read = scene::read_over(document, scene);
  return read.ok() ? read : in_flag_of_field(read.error());
}

Error in_flag_of_field(const Error& error) {
  const std::size_t end = error.message.find(": ");
  const std::string flag = flag_at(error.message.substr(0, end));
  return flag.empty() ? error : Error{flag + error.message.substr(end)};
}

Result<io::VolumeOptions> VolumeFlags::parse() const {
  scene::SceneFile scene;
  GVX_TRY(flags_.apply(scene));
  return open::volume_options(scene);
}

bool VolumeFlags::is_one(const FieldDescription& field) {
  const std::string_view group = field.flag.group;
  return group == scene::kRawGroup || group == scene::kChoiceGroup;
}

Error VolumeFlags::refuse(const std::string& path, const char* what) {
  std::vector<std::string> flags;
  for (const FieldDescription& field : scene::scene_fields()) {
    if (is_one(field)) flags.push_back(field.flag_name());
  }
  std::string text;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == flags.size() ? " and " : ", ") + flags[i];
  }
  return Error{path + ": " + text + " do not apply to " + what};
}

}  // namespace gvx::app
