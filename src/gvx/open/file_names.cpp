#include "gvx/open/file_names.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "gvx/io/mesh.h"
#include "gvx/io/mesh_parts.h"
#include "gvx/io/volume_reader.h"
#include "gvx/open/functions.h"
#include "gvx/open/open_volume.h"
#include "gvx/produce/hypertexture.h"

namespace gvx::open {
namespace {

namespace fs = std::filesystem;

/// Renames the files of an object.
template <typename Rename>
void rename_files(scene::ObjectParts& object, const Rename& rename) {
  if (object.volume) {
    const std::size_t file = file_position(*object.volume);
    object.volume = object.volume->substr(0, file) + rename(object.volume->substr(file));
  }
  for (scene::FunctionParts& function : object.functions) {
    if (!function.from.empty() && !is_preset(function.from)) function.from = rename(function.from);
  }
  if (object.labels && !object.labels->table.empty()) object.labels->table = rename(object.labels->table);
}

/// Those of all objects.
template <typename Rename>
void rename_all_files(scene::SceneFile& scene, const Rename& rename) {
  rename_files(scene, rename);
  for (scene::PlacedObject& object : scene.objects) rename_files(object, rename);
}

void add_files(const scene::ObjectParts& object, std::vector<std::string>& files) {
  if (object.volume) {
    const auto more = files_of(object.volume->substr(file_position(*object.volume)), volume_options(object));
    files.insert(files.end(), more.begin(), more.end());
  }
  for (const scene::FunctionParts& function : object.functions) {
    if (!function.from.empty()) files.push_back(function.from);
  }
  if (object.labels && !object.labels->table.empty()) files.push_back(object.labels->table);
}

/// Of what is no file: addresses, pipes.
bool has_no_place(const std::string& name) {
  return name == "-" || name.find("://") != std::string::npos;
}

}  // namespace

std::size_t file_position(const std::string& volume) {
  std::vector<std::string> kinds = {"repeat", "amplify", "cloud", "distance", "axis-distance"};
  kinds.insert(kinds.end(), produce::kHypertextureNames.begin(), produce::kHypertextureNames.end());
  std::size_t begin = 0;
  bool counted = false;  // a number may follow
  while (true) {
    const std::size_t colon = volume.find(':', begin);
    if (colon == std::string::npos) return begin;
    const std::string word = volume.substr(begin, colon - begin);
    const bool number = counted && !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
    if (!number && std::find(kinds.begin(), kinds.end(), word) == kinds.end()) return begin;
    counted = word == "repeat";
    begin = colon + 1;
  }
}

std::vector<std::string> files_of(const std::string& input, const io::VolumeOptions& options) {
  std::error_code error;
  const auto status = fs::status(input, error);
  // To look into a pipe would take away what is in it. What is not there may be a pattern.
  if (input == "-" || (exists(status) && !is_regular_file(status) && !is_directory(status))) return {input};
  return io::is_mesh_name(input) ? io::mesh_files(input) : io::volume_files(input, options);
}

std::vector<std::string> files_of_scene(const scene::SceneFile& scene) {
  std::vector<std::string> files;
  add_files(scene, files);
  for (const scene::PlacedObject& object : scene.objects) add_files(object, files);
  return files;
}

void resolve_names(scene::SceneFile& scene, const std::string& scene_path) {
  const fs::path folder = fs::path(scene_path).parent_path();
  rename_all_files(scene, [&](const std::string& name) {
    const fs::path here = folder / name;
    std::error_code ignored;
    const bool built_in = name.find_first_of("./") == std::string::npos && !fs::exists(here, ignored);
    return built_in || has_no_place(name) ? name : here.string();
  });
}

void relate_names(scene::SceneFile& scene, const std::string& scene_path) {
  std::error_code error;
  const fs::path folder = fs::absolute(scene_path, error).parent_path();
  rename_all_files(scene, [&](const std::string& name) {
    if (has_no_place(name) || !fs::exists(name, error)) return name;
    const fs::path there = fs::proximate(name, folder, error);
    return error ? fs::absolute(name).string() : there.string();
  });
}

}  // namespace gvx::open
