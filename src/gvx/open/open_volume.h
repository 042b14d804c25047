/// \file
/// open_volume: from what a scene says of a volume to a producer. A volume is a store, another program's
/// volume or mesh file, or a made scene by name. A mesh is shown as the surface that it is, unless the scene
/// asks for what only voxels have: a resolution, a clip box, a mode other than composite.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gvx/core/added_noise.h"
#include "gvx/core/result.h"
#include "gvx/io/volume_options.h"
#include "gvx/open/options.h"
#include "gvx/produce/producer.h"
#include "gvx/scene/scene_file.h"
#include "gvx/scene/transfer_function.h"
#include "gvx/scene/value_statistics.h"

namespace gvx::open {

/// A volume or a surface that can be rendered: the producer's tree says which.
struct OpenVolume {
  std::shared_ptr<const produce::Producer> producer;
  /// The preset that suits it.
  std::string preset;
  /// What rays add to its values.
  std::optional<AddedNoise> noise = {};
  /// Points that take the place of the preset's.
  std::vector<scene::ColorPoint> colors = {};
  std::vector<scene::OpacityPoint> opacities = {};
};

/// Opens the volume that `object` names, as its fields `raw`, `series`, `time`, `evenSlices`, `labels` and
/// `generate` say. File names are as seen from the working folder. Another program's volume or mesh becomes a
/// temporary store, which goes with the producer. An error where the volume cannot be opened, or where a
/// field of `generate` does not apply to it.
Result<OpenVolume> open_volume(const scene::ObjectParts& object, const OpenOptions& options = {});

/// Is the file a .gvx store, of a volume or a surface, by its first bytes? An error where it cannot be read.
Result<bool> is_store(const std::string& path);

/// What is said of a volume file, as readers take it.
io::VolumeOptions volume_options(const scene::ObjectParts& object);

/// What a transfer function can fit itself to.
scene::ValueStatistics value_statistics(const produce::TreeDescription& tree, std::size_t channel);

}  // namespace gvx::open
