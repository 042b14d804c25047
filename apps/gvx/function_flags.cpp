#include "function_flags.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "commands.h"
#include "gvx/io/header_text.h"
#include "gvx/io/label_table_file.h"
#include "gvx/scene/transfer_function.h"
#include "gvx/scene/transfer_presets.h"
#include "units.h"

namespace gvx::app {
namespace {

constexpr double kMostOpacity = 1000;

Result<scene::ValueWindow> parse_window(const std::string& text) {
  const auto numbers = parse_list(text);
  if (!numbers || numbers->size() != 2 || !((*numbers)[1] > 0)) {
    return Error{"--window: '" + text + "' is not LEVEL,WIDTH: two numbers, the width above 0, as 40,400"};
  }
  return scene::ValueWindow{(*numbers)[0], (*numbers)[1]};
}

Result<scene::PercentileRange> parse_percentiles(const std::string& text) {
  const auto numbers = parse_list(text);
  if (!numbers || numbers->size() != 2 || !((*numbers)[0] >= 0 && (*numbers)[0] < (*numbers)[1]) ||
      !((*numbers)[1] <= 100)) {
    return Error{"--percentile: '" + text +
                 "' is not LOW,HIGH: two numbers from 0 to 100, the first below the second, as 5,99.5"};
  }
  return scene::PercentileRange{(*numbers)[0], (*numbers)[1]};
}

/// Changes function i by value i. If there are fewer values, the last one is repeated.
template <typename Values, typename Change>
void change_functions(std::vector<scene::FunctionParts>& functions, const Values& values, Change change) {
  if (values.empty()) return;
  if (functions.empty()) functions.emplace_back();
  if (functions.size() < values.size())
    functions.resize(values.size(), scene::FunctionParts(functions.back()));
  for (std::size_t i = 0; i < functions.size(); ++i) {
    change(functions[i], values[std::min(i, values.size() - 1)]);
  }
}

std::string joined(std::span<const char* const> names) {
  std::string text;
  for (const char* name : names) text += std::string(text.empty() ? "" : " ") + name;
  return text;
}

}  // namespace

void FunctionFlags::add_to(CLI::App& command) {
  const auto one_at_a_time = [](CLI::Option* option) { option->allow_extra_args(false); };
  one_at_a_time(
      command
          .add_option(
              "--tf", functions_,
              "Transfer function: a ParaView JSON colour map, or a preset: " + joined(scene::preset_names()) +
                  " (default: a preset that suits the values). Give it once for each channel")
          ->check(not_empty()));
  one_at_a_time(command
                    .add_option("--window", windows_,
                                "LEVEL,WIDTH: fit the transfer function to the physical values from "
                                "LEVEL - WIDTH/2 to LEVEL + WIDTH/2. Give it once for each channel")
                    ->check(not_empty()));
  one_at_a_time(command
                    .add_option("--percentile", percentiles_,
                                "LOW,HIGH: fit the transfer function to the values between these "
                                "percentiles, such as 5,99.5. Give it once for each channel")
                    ->check(not_empty()));
  one_at_a_time(command.add_option("--opacity", opacities_,
                                   "Multiply all opacities of the transfer function, for example by 0.3. "
                                   "Give it once for each channel"));
  command
      .add_option("--gradient-opacity", gradients_,
                  "G0,F0,G1,F1,...: multiply the extinction (opacity per length) by F where the gradient is "
                  "G, in values per world unit")
      ->check(not_empty());
  labels_option_ =
      command
          .add_option(
              "--labels", labels_,
              "The numbers of the volume name classes. Each class has a colour of its own, or the one in "
              "FILE: a table of FreeSurfer, 3D Slicer or ITK-SNAP, CSV or TSV (default: as the volume says)")
          ->expected(0, 1)
          ->type_name("[FILE]");
  command.add_flag("--no-labels", no_labels_, "The numbers are values, even if the volume says labels")
      ->excludes(labels_option_);
}

void FunctionFlags::let_labels_precede(CLI::Option* scene, std::string* scene_name) {
  labels_option_->transform(CLI::Validator(
      [scene, scene_name](std::string& text) {
        if (text.empty() || scene->count() > 0 || io::is_label_table_name(text)) return std::string();
        scene->add_result(text);
        *scene_name = std::exchange(text, std::string());
        return std::string();
      },
      ""));
}

Status FunctionFlags::apply(scene::SceneFile& scene) const {
  if (!windows_.empty() && !percentiles_.empty())
    return Error{"--percentile: does not go with --window, which says the same"};
  if (!functions_.empty()) scene.functions.clear();
  for (const std::string& name : functions_) scene.functions.push_back({.from = name});
  std::vector<scene::ValueWindow> windows;
  for (const std::string& text : windows_) {
    GVX_ASSIGN(windows.emplace_back(), parse_window(text));
  }
  std::vector<scene::PercentileRange> percentiles;
  for (const std::string& text : percentiles_) {
    GVX_ASSIGN(percentiles.emplace_back(), parse_percentiles(text));
  }
  for (const double opacity : opacities_) {
    if (!(opacity >= 0 && opacity <= kMostOpacity)) {
      return Error{"--opacity: " + io::number_text(opacity) + " is not a factor from 0 to " +
                   io::number_text(kMostOpacity)};
    }
  }
  change_functions(scene.functions, windows, [](scene::FunctionParts& function, scene::ValueWindow window) {
    function.window = window;
    function.percentiles.reset();
  });
  change_functions(scene.functions, percentiles,
                   [](scene::FunctionParts& function, scene::PercentileRange range) {
                     function.percentiles = range;
                     function.window.reset();
                   });
  change_functions(scene.functions, opacities_,
                   [](scene::FunctionParts& function, double opacity) { function.opacity = opacity; });
  GVX_ASSIGN(const auto gradient_points, gradients());
  change_functions(scene.functions, std::vector(has_gradients() ? 1 : 0, gradient_points),
                   [](scene::FunctionParts& function, const auto& points) { function.gradients = points; });
  if (no_labels_) scene.labels = scene::LabelParts{false, ""};
  if (labels_option_->count() > 0) {
    const std::string table = !labels_.empty() ? labels_ : scene.labels ? scene.labels->table : "";
    scene.labels = scene::LabelParts{true, table};
  }
  return {};
}

Result<std::vector<scene::GradientPoint>> FunctionFlags::gradients() const {
  std::vector<scene::GradientPoint> points;
  if (gradients_.empty()) return points;
  const auto numbers = parse_list(gradients_);
  if (!numbers || numbers->size() % 2 != 0) {
    return Error{"--gradient-opacity: '" + gradients_ + "' is not pairs of numbers, as G0,F0,G1,F1"};
  }
  for (std::size_t i = 0; i < numbers->size(); i += 2) points.push_back({(*numbers)[i], (*numbers)[i + 1]});
  const Status sound = scene::check({{{0, {}}}, {{0, 0}}, 0, points});
  if (!sound.ok()) return Error{"--gradient-opacity: " + sound.error().message};
  return points;
}

std::string FunctionFlags::flag_of(const std::string& field) const {
  const bool said_labels = labels_option_->count() > 0 || no_labels_;
  if (field == "labels") return said_labels ? "--labels" : "";
  const std::pair<std::size_t, const char*> flags[] = {{functions_.size(), "--tf"},
                                                       {windows_.size(), "--window"},
                                                       {percentiles_.size(), "--percentile"},
                                                       {opacities_.size(), "--opacity"}};
  if (field == "functions") {
    const auto most = std::max_element(std::begin(flags), std::end(flags),
                                       [](const auto& a, const auto& b) { return a.first < b.first; });
    return most->first > 0 ? most->second : "";
  }
  if (field.ends_with(".gradients")) return has_gradients() ? "--gradient-opacity" : "";
  for (const auto& [count, flag] : flags) {
    if (count > 0 && (field.ends_with(flag + 2) || (field.ends_with(']') && flag == flags[0].second))) {
      return flag;
    }
  }
  return {};
}

}  // namespace gvx::app
