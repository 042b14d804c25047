/// \file
/// FunctionFlags: the flags that say what values and labels look like.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/scene/scene_file.h"

namespace gvx::app {

class FunctionFlags {
 public:
  void add_to(CLI::App& command);

  /// Lays --tf, --window, --percentile, --opacity, --gradient-opacity and --labels over a scene.
  Status apply(scene::SceneFile& scene) const;

  bool has_gradients() const { return !gradients_.empty(); }
  /// The flag by which a field of functions or labels was said; empty: by none. "functions" is said by the
  /// flag that was given most often.
  std::string flag_of(const std::string& field) const;
  /// --labels may stand before the scene: unless what follows it has the name of a table, it is the scene
  /// where there is none yet. To be called once the flags are added.
  void let_labels_precede(CLI::Option* scene, std::string* scene_name);

 private:
  Result<std::vector<scene::GradientPoint>> gradients() const;

  std::vector<std::string> functions_, windows_, percentiles_;
  std::vector<double> opacities_;
  std::string gradients_, labels_;
  bool no_labels_ = false;
  CLI::Option* labels_option_ = nullptr;
};

}  // namespace gvx::app
