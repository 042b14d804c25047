#include "gvx/open/functions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "gvx/io/label_table_file.h"
#include "gvx/io/transfer_function_file.h"
#include "gvx/open/closest_word.h"
#include "gvx/scene/transfer_limits.h"
#include "gvx/scene/transfer_presets.h"

namespace gvx::open {
namespace {

namespace fs = std::filesystem;

/// Of isosurfaces: ivory.
constexpr Vec3d kSurfaceColor{0.98, 0.91, 0.80};

Error no_such_function(const std::string& name) {
  std::string presets;
  for (const char* preset : scene::preset_names())
    presets += (presets.empty() ? "" : ", ") + std::string(preset);
  const std::vector<std::string> names(scene::preset_names().begin(), scene::preset_names().end());
  const auto near = closest_word(name, names);
  return Error{name + ": neither a file nor a preset (presets: " + presets + ")" +
               (near ? "; did you mean " + *near + "?" : "")};
}

/// "functions[0].window"; without `part` the function itself.
std::string function_field(std::size_t i, const std::string& part = "") {
  return "functions[" + std::to_string(i) + "]" + (part.empty() ? "" : "." + part);
}

Error in_function(const FieldNaming& naming, std::size_t i, const Error& error) {
  return Error{naming.before_value(function_field(i)) + error.message};
}

Result<scene::TransferFunction> read_function(const std::string& name) {
  std::error_code ignored;
  if (!fs::exists(name, ignored)) return no_such_function(name);
  return io::read_transfer_function(name);
}

Result<scene::TransferFunction> open_function(const scene::FunctionParts& parts,
                                              const scene::ValueStatistics& statistics) {
  if (parts.from.empty()) return parts.over({}, statistics);
  GVX_ASSIGN(auto function,
             is_preset(parts.from) ? scene::preset(parts.from, statistics) : read_function(parts.from));
  return parts.over(std::move(function), statistics);
}

/// Is a function, by name or points of its own, there?
bool has_points(const scene::FunctionParts& parts) {
  return !parts.from.empty() || !parts.colors.empty();
}

/// What gvx chooses where nothing is said.
scene::FunctionParts chosen_function(const scene::ObjectParts& scene, const scene::FunctionParts& parts,
                                     const OpenVolume& volume) {
  scene::FunctionParts chosen = parts;
  if (*scene.mode == scene::Mode::isosurface && parts == scene::FunctionParts()) {
    chosen.colors = {{0, kSurfaceColor}};
    chosen.opacities = {{0, 1}};
    return chosen;
  }
  const bool projection = scene::projects(*scene.mode);
  // The points of CT presets stand for matter: elsewhere they say nothing.
  const bool moved = parts.window || parts.percentiles;
  chosen.from = projection ? "ramp" : moved && volume.preset.starts_with("ct-") ? "gray" : volume.preset;
  if (projection) return chosen;
  chosen.colors = volume.colors;
  if (chosen.opacities.empty()) chosen.opacities = volume.opacities;
  return chosen;
}

/// Those of labels, whose colours are their own unless the scene has others.
Result<std::vector<scene::TransferFunction>> open_label_functions(const scene::ObjectParts& scene,
                                                                  const OpenVolume& volume,
                                                                  const FieldNaming& naming) {
  const produce::TreeDescription& tree = volume.producer->description();
  const scene::ValueStatistics statistics = value_statistics(tree, 0);
  const scene::FunctionParts parts = scene.functions.empty() ? scene::FunctionParts() : scene.functions[0];
  if (has_points(parts)) {
    auto function = open_function(parts, statistics);
    if (!function.ok()) return in_function(naming, 0, function.error());
    return std::vector{std::move(function).value()};
  }
  const auto labels = static_cast<std::uint32_t>(tree.ranges.channel[0].maximum) + 1;
  scene::TransferFunction base = scene::label_colors(labels);
  if (scene.labels && !scene.labels->table.empty()) {
    auto table = io::read_label_table(scene.labels->table);
    if (!table.ok()) return Error{naming.before_value("labels") + table.error().message};
    base = scene::label_colors(labels, table.value());
  }
  GVX_ASSIGN(auto function, parts.over(std::move(base), statistics));
  return std::vector{std::move(function)};
}

}  // namespace

bool is_preset(const std::string& name) {
  const auto names = scene::preset_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

Status check_function_files(const scene::ObjectParts& scene, const OpenOptions& options) {
  std::error_code ignored;
  for (std::size_t i = 0; i < scene.functions.size(); ++i) {
    const std::string& name = scene.functions[i].from;
    // Files are read again later; what is in a pipe could not be.
    if (name.empty() || is_preset(name) ||
        (fs::exists(name, ignored) && !fs::is_regular_file(name, ignored))) {
      continue;
    }
    if (const auto function = read_function(name); !function.ok()) {
      return in_function(options.naming, i, function.error());
    }
  }
  if (!scene.labels || scene.labels->table.empty()) return {};
  const std::string& table = scene.labels->table;
  const std::string labels = options.naming.before_value("labels");
  if (fs::exists(table, ignored) && !fs::is_regular_file(table, ignored)) {
    return Error{labels + table + ": expected a file"};
  }
  std::vector<std::string> warnings;
  if (const auto read = io::read_label_table(table, &warnings); !read.ok()) {
    return Error{labels + read.error().message};
  }
  for (const std::string& warning : warnings) options.warn(labels + warning);
  if (!scene.functions.empty() && has_points(scene.functions[0])) {
    return Error{labels + table + ": does not go with a transfer function (" +
                 options.naming.name(function_field(0)) + "), which says colours too"};
  }
  return {};
}

Status check_functions(const scene::ObjectParts& scene, const VoxelFormat& format,
                       const FieldNaming& naming) {
  const bool labels = format.content == VoxelContent::labels;
  for (std::size_t i = 0; i < scene.functions.size() && format.content != VoxelContent::scalar; ++i) {
    if (scene.functions[i].gradients.empty()) continue;
    return Error{naming.name(function_field(i, "gradients")) + ": the volume's voxels have no gradient"};
  }
  const std::size_t most = labels || format.content == VoxelContent::scalar ? format.channels() : 0;
  if (scene.functions.size() > most) {
    return Error{naming.name("functions") + ": " + std::to_string(scene.functions.size()) +
                 " transfer functions for a volume that takes " + std::to_string(most)};
  }
  if (labels && !scene.functions.empty() && (scene.functions[0].window || scene.functions[0].percentiles)) {
    return Error{naming.name(function_field(0, scene.functions[0].window ? "window" : "percentile")) +
                 ": the volume's numbers are labels, which have no range (" +
                 naming.advice("--no-labels", "\"labels\": false") + " shows them as values)"};
  }
  if (scene.labels && scene.labels->enabled && !labels) {
    return Error{naming.name("labels") + ": the volume's numbers are no labels" +
                 naming.advice("; gvx build INPUT --labels makes a store of some", "")};
  }
  return {};
}

Result<std::vector<scene::FunctionParts>> complete_functions(const scene::ObjectParts& scene,
                                                             const OpenVolume& volume,
                                                             const FieldNaming& naming) {
  const produce::TreeDescription& tree = volume.producer->description();
  GVX_TRY(check_functions(scene, tree.format, naming));
  std::vector<scene::FunctionParts> functions = scene.functions;
  if (tree.format.content != VoxelContent::scalar) return functions;
  if (functions.empty()) functions.emplace_back();
  for (std::size_t i = 0; i < functions.size(); ++i) {
    scene::FunctionParts& function = functions[i];
    if (!has_points(function)) function = chosen_function(scene, function, volume);
    if (function.percentiles && tree.histograms.empty()) {
      return Error{naming.name(function_field(i, "percentile")) + ": the volume has no histogram; " +
                   naming.advice("--window LEVEL,WIDTH", "window") + " does the same"};
    }
  }
  functions.resize(tree.format.channels(), functions.back());
  return functions;
}

Result<std::vector<scene::TransferFunction>> open_functions(const scene::ObjectParts& scene,
                                                            const OpenVolume& volume,
                                                            const FieldNaming& naming) {
  const produce::TreeDescription& tree = volume.producer->description();
  if (tree.format.content == VoxelContent::labels) return open_label_functions(scene, volume, naming);
  std::vector<scene::TransferFunction> functions;
  for (std::size_t channel = 0; channel < scene.functions.size(); ++channel) {
    auto function = open_function(scene.functions[channel], value_statistics(tree, channel));
    if (!function.ok()) return in_function(naming, channel, function.error());
    functions.push_back(std::move(function).value());
  }
  return functions;
}

void warn_of_close_points(const produce::TreeDescription& tree,
                          const std::vector<scene::TransferFunction>& functions, const Warn& warn) {
  if (tree.format.content != VoxelContent::scalar) return;
  for (std::size_t channel = 0; channel < functions.size(); ++channel) {
    const scene::ValueStatistics values = value_statistics(tree, channel);
    const auto close = scene::points_too_close(functions[channel], {values.minimum, values.maximum});
    if (!close) continue;
    std::ostringstream message;
    message.precision(9);
    message << "transfer function: the points at " << close->first << " and " << close->second
            << " are too close to tell apart: the volume's values are from " << values.minimum << " to "
            << values.maximum;
    warn(message.str());
  }
}

Result<nlohmann::json> label_legend(const scene::ObjectParts& scene, const scene::TransferFunction& function,
                                    const OpenVolume& volume) {
  nlohmann::json legend = nlohmann::json::array();
  if (!scene.labels || scene.labels->table.empty()) return legend;
  const ValueRange range = volume.producer->description().ranges.channel[0];
  GVX_ASSIGN(const scene::LabelTable table, io::read_label_table(scene.labels->table));
  for (const auto& [label, entry] : table) {
    if (label == 0 || double(label) < double(range.minimum) || double(label) > double(range.maximum))
      continue;
    const Vec3d color = function.color(label);
    std::array<char, 8> text{};
    std::snprintf(text.data(), text.size(), "#%02x%02x%02x", unsigned(std::lround(255 * color.x)),
                  unsigned(std::lround(255 * color.y)), unsigned(std::lround(255 * color.z)));
    legend.push_back({{"label", label}, {"name", entry.name}, {"color", text.data()}});
  }
  return legend;
}

}  // namespace gvx::open
