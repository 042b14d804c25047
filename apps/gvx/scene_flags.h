/// \file
/// SceneFlags: the flags of a scene, one a field of a scene file.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "function_flags.h"
#include "gvx/core/result.h"
#include "gvx/scene/camera.h"
#include "gvx/scene/scene_file.h"
#include "open_scene.h"

namespace gvx::app {

class SceneFlags {
 public:
  void add_to(CLI::App& command);

  /// Lays the flags that were given over a scene: all but those below.
  Status apply(scene::SceneFile& scene) const;

  // What is laid over what depends on the volume.

  /// What --view and --camera say.
  Result<scene::CameraParts> camera() const;
  /// --key-frame; none where none is given.
  Result<std::vector<scene::KeyFrameParts>> key_frames() const;
  const FunctionFlags& functions() const { return functions_; }
  FunctionFlags& functions() { return functions_; }
  bool has_volume() const { return !volume_.empty(); }
  bool has_isovalue() const { return isovalue_.has_value(); }
  /// Was anything said of a raw file?
  bool has_raw() const { return volume_flags_.given(); }

 private:
  Status apply_lighting(scene::LightingParts& lighting) const;
  Status apply_volume(scene::SceneFile& scene) const;
  void add_generate_to(CLI::App& command);
  void apply_generate(scene::GenerateParts& parts) const;

  std::string volume_, up_axis_, size_, camera_, view_, mode_, classification_, clip_, background_;
  std::vector<std::string> key_frames_, lights_;
  std::optional<std::uint32_t> antialias_;
  std::optional<double> isovalue_, ambient_, diffuse_, specular_, shininess_, samples_, detail_;
  bool shaded_ = true, transparent_ = false, finest_ = false, in_march_ = false;
  CLI::Option *shaded_option_ = nullptr, *transparent_option_ = nullptr, *finest_option_ = nullptr;
  VolumeFlags volume_flags_;
  FunctionFlags functions_;
  scene::GenerateParts generate_;
};

}  // namespace gvx::app
