/// \file
/// SceneFile: a picture in words, as a JSON file holds it: what is shown, from where, and how. What is left
/// out the program chooses. docs/scene-file.md describes the fields, docs/scene.schema.json is their JSON
/// Schema.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/core/vec.h"
#include "gvx/scene/camera_parts.h"
#include "gvx/scene/camera_path.h"
#include "gvx/scene/function_range.h"
#include "gvx/scene/lighting.h"
#include "gvx/scene/transfer_function.h"
#include "gvx/scene/value_statistics.h"
#include "gvx/scene/visibility.h"

namespace gvx::scene {

/// The names of Mode and LightKind, in their order.
inline constexpr const char* kClassificationNames[] = {"preintegrated", "post"};
inline constexpr const char* kModeNames[] = {"composite", "maximum", "minimum", "mean", "isosurface"};
inline constexpr const char* kLightKindNames[] = {"camera", "directional", "point"};

/// What is known of a raw file beside its name.
struct RawParts {
  std::optional<Vec3i> dimensions;
  std::optional<std::string> type;  ///< u8 i8 u16 i16 u32 i32 f32 f64
  std::optional<bool> big_endian;
  std::optional<std::int64_t> offset;  ///< bytes
  std::optional<Vec3d> spacing;
  std::optional<int> components;  ///< samples a voxel

  bool operator==(const RawParts&) const = default;
};

/// What is said of a scene that is made, not loaded; which takes what is in docs/scene-file.md.
struct GenerateParts {
  std::optional<std::int64_t> levels;      ///< of the tree, the root included
  std::optional<std::int64_t> resolution;  ///< voxels along the longest side of a mesh
  std::optional<std::int64_t> octaves, seed;
  std::optional<double> wavelength, gain;  ///< of the first octave; of an octave beside the one before
  std::optional<double> strength, thickness;
  std::optional<bool> in_march;  ///< noise is added as rays march, not in bricks

  bool operator==(const GenerateParts&) const = default;
};

struct KeyFrameParts {
  double frame = 0;
  CameraParts camera;

  bool operator==(const KeyFrameParts&) const = default;
};

/// A transfer function by name, with points of its own, or both. Without either it is what the program
/// chooses.
struct FunctionParts {
  std::string from;  ///< a preset or a ParaView JSON file; empty: none
  std::vector<ColorPoint> colors = {};
  std::vector<OpacityPoint> opacities = {};
  std::optional<double> unit_distance = {};
  std::vector<GradientPoint> gradients = {};
  // Where the function's first and last point come to lie; at most one of them.
  std::optional<ValueWindow> window = {};
  std::optional<PercentileRange> percentiles = {};
  std::optional<double> opacity = {};  ///< factor of all opacities

  /// `base`, which `from` names, with the parts that are there; an error where that is no sound function.
  /// `statistics` are of the volume.
  Result<TransferFunction> over(TransferFunction base, const ValueStatistics& statistics = {}) const;
  bool operator==(const FunctionParts&) const = default;
};

/// Whether a volume file's numbers are labels.
struct LabelParts {
  bool enabled = true;
  std::string table;  ///< a file of their names and colours; empty: none

  bool operator==(const LabelParts&) const = default;
};

struct LightingParts {
  std::optional<bool> enabled;
  std::optional<double> ambient, diffuse, specular, shininess;
  std::optional<std::vector<Light>> lights;

  LightingParts() = default;
  /// All parts of it.
  explicit LightingParts(const Lighting& lighting);
  Lighting over(const Lighting& base) const;
  bool operator==(const LightingParts&) const = default;
};

/// Plain data, as written: names of files are as seen from the scene file's folder.
struct SceneFile {
  std::optional<std::string> volume;
  std::optional<UpAxis> up_axis;  ///< of the volume's world; a patient's too
  RawParts raw;
  std::optional<std::string> series;  ///< of a folder of DICOM files: its number or UID
  std::optional<std::int64_t> time;   ///< frame of a volume that changes with time
  std::optional<bool> even_slices;    ///< slices that are uneven or tilted are resampled
  GenerateParts generate;
  std::optional<std::uint32_t> width, height;  ///< both or none
  std::optional<std::uint32_t> antialias;
  CameraParts camera;
  std::vector<KeyFrameParts> camera_path;  ///< parts that are left out are those of `camera`
  std::optional<Mode> mode;
  std::optional<double> isovalue;
  std::optional<Classification> classification;
  std::vector<FunctionParts> functions;  ///< one a channel; fewer repeat the last
  std::optional<LabelParts> labels;      ///< none: as the volume's file says
  LightingParts lighting;
  std::optional<Box3d> clip;
  std::optional<Vec3d> background;
  std::optional<bool> transparent;
  std::optional<double> samples;
  std::optional<double> detail;
  std::optional<bool> finest;

  bool operator==(const SceneFile&) const = default;
};

/// Reads a file of at most 16 MiB. An error is one line: "PATH: FIELD: what was expected, what was found".
Result<SceneFile> read_scene(const std::string& path);

/// The same from a text; `name` stands for the path in errors.
Result<SceneFile> parse_scene(const std::string& text, const std::string& name);

/// What read_scene reads: the fields that are there, lists of numbers on one line.
std::string to_json(const SceneFile& scene);

}  // namespace gvx::scene
