/// \file
/// FieldFlags: the flags of a scene's fields, one a field, as the table of fields has them. VolumeFlags:
/// those of volume files.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <deque>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "gvx/core/result.h"
#include "gvx/io/volume_options.h"
#include "gvx/scene/scene_fields.h"

namespace gvx::app {

class FieldFlags {
 public:
  using Choice = std::function<bool(const scene::FieldDescription&)>;

  /// Adds the flags of the fields that are chosen; all that have one, if nothing is.
  void add_to(CLI::App& command, const Choice& chosen = {});
  /// Was one of these flags given?
  bool given(const Choice& chosen) const;
  /// Was the flag of this field given?
  bool given(std::string_view path) const;
  /// Puts the fields whose flags were given in the place of those of a scene. An error names the flag.
  Status apply(scene::SceneFile& scene) const;

 private:
  struct Flag {
    const scene::FieldDescription& field;
    CLI::Option* option = nullptr;
    // What was given, by the field's form.
    std::string text = {};
    double number = 0;
    std::uint64_t whole = 0;
    bool yes = false;
  };

  static Result<nlohmann::json> value_of(const Flag& flag);

  std::deque<Flag> flags_;  // which the parser points into
};

/// An error of a scene's field, "lighting.ambient: expected ...", with the name of the flag that says the
/// same.
Error in_flag_of_field(const Error& error);

/// What is said of a volume file: a raw file's shape, and which of its series or frames is meant.
class VolumeFlags {
 public:
  void add_to(CLI::App& command) { flags_.add_to(command, is_one); }
  Result<io::VolumeOptions> parse() const;
  /// Was any of them given?
  bool given() const { return flags_.given(is_one); }
  /// Is it the field of one of them?
  static bool is_one(const scene::FieldDescription& field);
  /// The error for input that they say nothing of.
  static Error refuse(const std::string& path, const char* what = "a mesh");

 private:
  FieldFlags flags_;
};

}  // namespace gvx::app
