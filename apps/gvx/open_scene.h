/// \file
/// From what is typed as SCENE to a producer: a store, another program's volume file, or a built-in scene by
/// name.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/exec/device.h"
#include "gvx/io/volume_options.h"
#include "gvx/produce/producer.h"
#include "gvx/scene/scene_file.h"
#include "gvx/scene/transfer_function.h"
#include "gvx/scene/value_statistics.h"

namespace gvx::app {

/// Is the file a .gvx store, by its first bytes? An error where it cannot be read.
Result<bool> is_store(const std::string& path);

struct Scene {
  std::shared_ptr<const produce::Producer> producer;
  /// The preset that suits it.
  std::string preset;
  /// What rays add to its values.
  std::optional<AddedNoise> noise = {};
  /// Points that take the place of the preset's.
  std::vector<scene::ColorPoint> colors = {};
  std::vector<scene::OpacityPoint> opacities = {};
};

struct Devices {
  exec::Device cpu;     ///< for what only runs there
  exec::Device render;  ///< where pictures are made, and what kernels make of them
  bool quiet = false;   ///< says nothing of how far it is
};

/// Asked with what is known of a volume or mesh file before it is built into a store, which takes time.
using BeforeBuild = std::function<Status(const VoxelFormat&)>;

/// Opens SCENE. `parts` say how it is made. An error where one of them does not apply to the scene, or where
/// `before_build` fails. Another program's volume or mesh is built into a store without a name in the
/// temporary folder, which goes when the program does; warnings of that go to standard error.
Result<Scene> open_scene(const Devices& devices, const std::string& name, const io::VolumeOptions& options,
                         scene::GenerateParts parts, const BeforeBuild& before_build);

/// What a transfer function can fit itself to.
scene::ValueStatistics value_statistics(const produce::TreeDescription& tree, std::size_t channel);

/// What is said of a volume file: a raw file's shape (--dims, --dtype, --endian, --offset, --spacing), and
/// which of its series or frames is meant (--series, --time, --even-slices).
class VolumeFlags {
 public:
  void add_to(CLI::App& command);
  Result<io::VolumeOptions> parse() const;
  /// Was any of them given?
  bool given() const;
  /// The error for input that they say nothing of.
  static Error refuse(const std::string& path, const char* what = "a mesh");

 private:
  std::string dims_, dtype_, endian_, spacing_;
  std::optional<std::int64_t> offset_;
  std::optional<int> components_;
  std::string series_;
  std::optional<std::int64_t> time_;
  bool even_slices_ = false;
};

}  // namespace gvx::app
