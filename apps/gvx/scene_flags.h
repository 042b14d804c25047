/// \file
/// SceneFlags: the flags of a scene.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "field_flags.h"
#include "function_flags.h"
#include "gvx/core/result.h"
#include "gvx/scene/camera_parts.h"
#include "gvx/scene/scene_file.h"

namespace gvx::app {

class SceneFlags {
 public:
  void add_to(CLI::App& command);

  /// Lays the flags that were given over a scene. An error where flags are wrong or do not go together.
  Status apply(scene::SceneFile& scene) const;

  FunctionFlags& functions() { return functions_; }
  bool has_volume() const { return fields_.given("volume"); }
  /// Was anything said of a raw file?
  bool has_raw() const { return fields_.given(VolumeFlags::is_one); }
  /// The flag by which a field was said, for open::FieldNaming.
  std::string flag_of(const std::string& field) const { return functions_.flag_of(field); }

 private:
  /// What --view and --camera say.
  Result<scene::CameraParts> camera() const;
  Result<std::vector<scene::KeyFrameParts>> key_frames() const;
  Status apply_cameras(scene::SceneFile& scene) const;
  Status check_mode(const scene::SceneFile& scene) const;

  std::string camera_, view_;
  std::vector<std::string> key_frames_, lights_;
  FieldFlags fields_;
  FunctionFlags functions_;
};

}  // namespace gvx::app
