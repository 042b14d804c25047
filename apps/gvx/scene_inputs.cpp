#include "scene_inputs.h"

#include <filesystem>

#include "built_in_scenes.h"
#include "gvx/io/mesh.h"
#include "gvx/io/mesh_parts.h"
#include "gvx/io/volume_reader.h"
#include "scene_view.h"

namespace gvx::app {

std::vector<std::string> files_of(const std::string& input, const io::VolumeOptions& options) {
  std::error_code error;
  const auto status = std::filesystem::status(input, error);
  // To look into a pipe would take away what is in it. What is not there may be a pattern.
  if (input == "-" || (exists(status) && !is_regular_file(status) && !is_directory(status))) return {input};
  return io::is_mesh_name(input) ? io::mesh_files(input) : io::volume_files(input, options);
}

std::vector<std::string> files_of_scene(const std::string& scene_path, const scene::SceneFile& scene,
                                        const std::string& proxy) {
  std::vector<std::string> files = {scene_path};
  const auto add = [&](const std::vector<std::string>& more) {
    files.insert(files.end(), more.begin(), more.end());
  };
  if (scene.volume) add(files_of(scene.volume->substr(file_position(*scene.volume)), volume_options(scene)));
  for (const scene::FunctionParts& function : scene.functions) {
    if (!function.from.empty()) files.push_back(function.from);
  }
  if (scene.labels && !scene.labels->table.empty()) files.push_back(scene.labels->table);
  if (!proxy.empty()) add(files_of(proxy, {}));
  return files;
}

}  // namespace gvx::app
