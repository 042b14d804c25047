/// \file
/// The table of a scene's fields: what each is called in scene files and on a command line, what it holds,
/// and how it is read and written. A field that is added to SceneFile needs one row in scene_fields.cpp.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/scene/json_fields.h"
#include "gvx/scene/scene_file.h"

namespace gvx::scene {

/// What a field holds.
enum class FieldForm {
  text,
  number,
  whole,      ///< a whole number
  choice,     ///< one of some names
  yes_or_no,  ///< true or false
  numbers,    ///< a list of numbers
  size,       ///< a width and a height
  other       ///< objects, lists, and what can be written in several ways
};

/// A field as a command line knows it.
struct FlagText {
  /// "--samples"; "--shaded,!--flat" with the flag that says no; null: no flag, or one of its own syntax.
  const char* names = nullptr;
  const char* help = "";
  const char* group = "";     ///< the heading in a list of flags
  const char* expected = "";  ///< of numbers and sizes: what their text should be, such as "three numbers"
};

struct FieldDescription {
  std::string path;  ///< "lighting.ambient"
  FieldForm form = FieldForm::other;
  FlagText flag = {};
  std::span<const char* const> choices = {};
  NumberRange range = {};  ///< of each number
  std::size_t count = 1;   ///< of the numbers in a list

  /// "--shaded": the flag that is named in sentences; empty where there is none.
  std::string flag_name() const;
};

inline constexpr const char* kRawGroup = "Raw input";
inline constexpr const char* kChoiceGroup = "Volumes with several series or frames";
inline constexpr const char* kMadeGroup =
    "Made scenes (docs/made-scenes.md says which scene has which parameters)";

/// All fields of a scene, with those of the objects in it.
const std::vector<FieldDescription>& scene_fields();

/// Puts the fields of a document in the place of those of a scene; what it does not say stays as it is. An
/// error names the field. Cameras and lists are replaced as a whole.
Status read_over(const nlohmann::json& document, SceneFile& scene);

/// The names of the fields of `parts` that are set.
std::vector<std::string> set_fields(const GenerateParts& parts);

/// A document with the fields that are set.
nlohmann::ordered_json to_document(const SceneFile& scene);

}  // namespace gvx::scene
