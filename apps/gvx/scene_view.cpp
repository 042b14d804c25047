#include "scene_view.h"

#include <algorithm>
#include <filesystem>

#include "built_in_scenes.h"
#include "gvx/io/transfer_function_file.h"

namespace gvx::app {
namespace {

namespace fs = std::filesystem;

bool is_preset(const std::string& name) {
  const auto names = scene::preset_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

Result<scene::TransferFunction> open_function(const scene::FunctionParts& parts,
                                              const scene::ValueStatistics& statistics) {
  if (parts.from.empty()) return parts.over({});
  std::error_code ignored;
  if (!is_preset(parts.from) && fs::exists(parts.from, ignored)) {
    GVX_ASSIGN(auto function, io::read_transfer_function(parts.from));
    return parts.over(std::move(function));
  }
  auto function = scene::preset(parts.from, statistics);
  if (!function.ok()) return Error{"no file and " + function.error().message};
  return parts.over(std::move(function).value());
}

bool takes_functions(const produce::TreeDescription& tree) {
  return tree.format.content == VoxelContent::scalar || tree.format.content == VoxelContent::labels;
}

/// One a channel; none for labels, whose colours are their own, unless the scene has one.
Result<std::vector<scene::FunctionParts>> complete_functions(const scene::SceneFile& scene,
                                                             const SceneFlags& flags, const Scene& opened) {
  const produce::TreeDescription& tree = opened.producer->description();
  const std::size_t channels = tree.format.channels();
  std::vector<scene::FunctionParts> functions = scene.functions;
  GVX_ASSIGN(const auto gradients, flags.gradients());
  if (functions.size() > channels || (!functions.empty() && !takes_functions(tree))) {
    return Error{"functions: " + std::to_string(functions.size()) + " for a volume that takes " +
                 std::to_string(takes_functions(tree) ? channels : 0)};
  }
  if (tree.format.content != VoxelContent::scalar) {
    if (!gradients.empty()) return Error{"--gradient-opacity: the volume's voxels have no gradient"};
    return functions;
  }
  const bool projection = *scene.mode != scene::Mode::composite && *scene.mode != scene::Mode::isosurface;
  if (!gradients.empty() && *scene.mode != scene::Mode::composite) {
    return Error{"--gradient-opacity: only mode composite has opacities"};
  }
  if (functions.empty() && projection) functions.push_back({.from = "ramp"});
  if (functions.empty()) {
    functions.push_back({.from = opened.preset, .colors = opened.colors, .opacities = opened.opacities});
  }
  functions.resize(channels, functions.back());
  if (!gradients.empty()) {
    for (scene::FunctionParts& function : functions) function.gradients = gradients;
  }
  return functions;
}

Status check_isovalue(const scene::SceneFile& scene, const SceneFlags& flags,
                      const scene::ValueStatistics& statistics) {
  if (*scene.mode != scene::Mode::isosurface) {
    if (flags.has_isovalue()) return Error{"--isovalue: only mode isosurface has one"};
    return {};
  }
  if (scene.isovalue) return {};
  return Error{"isovalue: mode isosurface needs one (--isovalue); the volume's values are from " +
               std::to_string(statistics.minimum) + " to " + std::to_string(statistics.maximum)};
}

template <typename Rename>
void rename_files(scene::SceneFile& scene, Rename rename) {
  if (scene.volume) {
    const std::size_t file = file_position(*scene.volume);
    scene.volume = scene.volume->substr(0, file) + rename(scene.volume->substr(file));
  }
  for (scene::FunctionParts& function : scene.functions) {
    if (!function.from.empty() && !is_preset(function.from)) function.from = rename(function.from);
  }
}

/// Of what is no file: addresses, pipes.
bool has_no_place(const std::string& name) {
  return name == "-" || name.find("://") != std::string::npos;
}

}  // namespace

io::RawOptions raw_options(const scene::RawParts& raw) {
  io::RawOptions options;
  options.dimensions = raw.dimensions;
  if (raw.type) options.type = io::parse_sample_type(*raw.type);
  options.big_endian = raw.big_endian;
  options.offset = raw.offset;
  options.spacing = raw.spacing;
  options.components = raw.components;
  return options;
}

Result<scene::SceneFile> complete(scene::SceneFile scene, const SceneFlags& flags, const Scene& opened) {
  const produce::TreeDescription& tree = opened.producer->description();
  const render::View standard;
  if (!scene.width) scene.width = standard.width;
  if (!scene.height) scene.height = standard.height;
  if (!scene.antialias) scene.antialias = standard.antialias;
  const scene::Camera framed = scene::frame_box(tree.extent, tree.tree_to_world, tree.anatomical,
                                                double(*scene.width) / double(*scene.height));
  GVX_ASSIGN(const scene::Camera camera, flags.camera(scene.camera.over(framed)));
  scene.camera = scene::CameraParts(camera);
  GVX_ASSIGN(const auto key_frames, flags.key_frames(camera));
  if (!key_frames.empty()) scene.camera_path = key_frames;
  for (scene::KeyFrameParts& key : scene.camera_path)
    key.camera = scene::CameraParts(key.camera.over(camera));
  if (!scene.mode) scene.mode = standard.mode;
  if (!scene.classification) scene.classification = standard.classification;
  GVX_TRY(check_isovalue(scene, flags, value_statistics(tree, 0)));
  GVX_ASSIGN(scene.functions, complete_functions(scene, flags, opened));
  scene.lighting = scene::LightingParts(scene.lighting.over(standard.lighting));
  if (!scene.clip) scene.clip = standard.clip;
  if (!scene.background) scene.background = Vec3d(standard.background);
  if (!scene.transparent) scene.transparent = !standard.opaque_background;
  if (!scene.samples) scene.samples = standard.samples_per_voxel;
  if (!scene.detail) scene.detail = standard.detail;
  if (!scene.finest) scene.finest = !standard.level_of_detail;
  return scene;
}

Result<render::View> make_view(const scene::SceneFile& scene, const Scene& opened) {
  const produce::TreeDescription& tree = opened.producer->description();
  render::View view;
  view.width = *scene.width;
  view.height = *scene.height;
  view.antialias = *scene.antialias;
  view.camera = scene.camera.over({});
  view.mode = *scene.mode;
  view.isovalue = scene.isovalue.value_or(0);
  view.classification = *scene.classification;
  for (std::size_t channel = 0; channel < scene.functions.size(); ++channel) {
    auto function = open_function(scene.functions[channel], value_statistics(tree, channel));
    if (!function.ok())
      return Error{"functions[" + std::to_string(channel) + "]: " + function.error().message};
    view.functions.push_back(std::move(function).value());
  }
  if (tree.format.content == VoxelContent::labels && view.functions.empty()) {
    const auto greatest = static_cast<std::uint32_t>(tree.ranges.channel[0].maximum);
    view.functions = {scene::label_colors(greatest + 1)};
  }
  view.lighting = scene.lighting.over(view.lighting);
  view.clip = *scene.clip;
  view.background = Vec3f(*scene.background);
  view.opaque_background = !*scene.transparent;
  view.samples_per_voxel = *scene.samples;
  view.detail = *scene.detail;
  view.level_of_detail = !*scene.finest;
  view.noise = opened.noise;
  return view;
}

void resolve_names(scene::SceneFile& scene, const std::string& scene_path) {
  const fs::path folder = fs::path(scene_path).parent_path();
  rename_files(scene, [&](const std::string& name) {
    const fs::path here = folder / name;
    std::error_code ignored;
    const bool built_in = name.find_first_of("./") == std::string::npos && !fs::exists(here, ignored);
    return built_in || has_no_place(name) ? name : here.string();
  });
}

void relate_names(scene::SceneFile& scene, const std::string& scene_path) {
  std::error_code error;
  const fs::path folder = fs::absolute(scene_path, error).parent_path();
  rename_files(scene, [&](const std::string& name) {
    if (has_no_place(name) || !fs::exists(name, error)) return name;
    const fs::path there = fs::proximate(name, folder, error);
    return error ? fs::absolute(name).string() : there.string();
  });
}

}  // namespace gvx::app
