/// \file
/// SceneFile holds the fields of a scene file, a JSON file that describes a picture. All fields are optional;
/// the program chooses what is left out. docs/scene-file.md describes the fields. docs/scene.schema.json is
/// their JSON Schema.
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
#include "gvx/scene/transform_parts.h"
#include "gvx/scene/value_statistics.h"
#include "gvx/scene/visibility.h"

namespace gvx::scene {

/// The names of Classification, Mode and LightKind, in the order of their values.
inline constexpr const char* kClassificationNames[] = {"preintegrated", "post"};
inline constexpr const char* kModeNames[] = {"composite", "maximum", "minimum", "mean", "isosurface"};
inline constexpr const char* kLightKindNames[] = {"camera", "directional", "point"};

/// The shape and type of raw samples. Parts that are missing come from the file's name.
struct RawParts {
  std::optional<Vec3i> dimensions;
  std::optional<std::string> type;  ///< u8 i8 u16 i16 u32 i32 u64 i64 f32 f64
  std::optional<bool> big_endian;
  std::optional<std::int64_t> offset;  ///< bytes before the first sample
  std::optional<Vec3d> spacing;        ///< of a voxel; used for every format
  std::optional<int> components;       ///< numbers per voxel

  bool operator==(const RawParts&) const = default;
};

/// Parameters of a made scene. docs/made-scenes.md says which scene has which parameters.
struct GenerateParts {
  std::optional<std::int64_t> levels;         ///< levels of detail, the coarsest included
  std::optional<std::int64_t> resolution;     ///< voxels along the longest side of a mesh
  std::optional<std::int64_t> octaves, seed;  ///< of the noise
  std::optional<double> wavelength;           ///< of the first octave, as a fraction of the scene's cube
  std::optional<double> gain;                 ///< strength of an octave, relative to the one before
  std::optional<double> strength;             ///< of the noise
  std::optional<double> thickness;  ///< of the shell around a surface, as a fraction of the scene's cube
  std::optional<bool> in_march;     ///< compute noise at each sample of a ray instead of in bricks

  bool operator==(const GenerateParts&) const = default;
};

/// A camera at a place in time.
struct KeyFrameParts {
  double frame = 0;  ///< need not be whole
  CameraParts camera;

  bool operator==(const KeyFrameParts&) const = default;
};

/// A transfer function: a name, points, or both. Points replace those of the named function. Without either,
/// the program chooses a function.
struct FunctionParts {
  std::string from;  ///< name of a preset, or path of a ParaView JSON file; empty: none
  std::vector<ColorPoint> colors = {};
  std::vector<OpacityPoint> opacities = {};
  std::optional<double> unit_distance = {};
  std::vector<GradientPoint> gradients = {};
  // The function's first and last point move to the ends of this range. At most one of the two is set.
  std::optional<ValueWindow> window = {};
  std::optional<PercentileRange> percentiles = {};
  std::optional<double> opacity = {};  ///< multiplies all opacities; products above 1 count as 1

  /// The function with these parts over `base`, the function that `from` names. `statistics` are those of the
  /// volume. An error if the result is not a valid function.
  Result<TransferFunction> over(TransferFunction base, const ValueStatistics& statistics = {}) const;
  bool operator==(const FunctionParts&) const = default;
};

/// Says whether a volume's numbers are labels, which name classes.
struct LabelParts {
  bool enabled = true;
  std::string table;  ///< path of a table of names and colours; empty: none

  bool operator==(const LabelParts&) const = default;
};

struct LightingParts {
  std::optional<bool> enabled;
  std::optional<double> ambient, diffuse, specular, shininess;
  std::optional<std::vector<Light>> lights;

  LightingParts() = default;
  /// Takes all parts from `lighting`.
  explicit LightingParts(const Lighting& lighting);
  /// `base`, with the parts that are set in its place.
  Lighting over(const Lighting& base) const;
  bool operator==(const LightingParts&) const = default;
};

/// What a scene says of one volume: where it comes from, and what is seen of it.
struct ObjectParts {
  std::optional<std::string> volume;
  RawParts raw;
  std::optional<std::string> series;  ///< of a DICOM folder: number or UID; of an OME-TIFF file: number
  std::optional<std::int64_t> time;   ///< frame of a volume that changes with time, from 0
  std::optional<bool> even_slices;    ///< resample tilted, uneven or missing DICOM slices
  GenerateParts generate;
  std::optional<Mode> mode;
  std::optional<double> isovalue;
  std::optional<Classification> classification;
  std::vector<FunctionParts> functions;  ///< one for each channel; if there are fewer, the last is repeated
  std::optional<LabelParts> labels;      ///< not set: as the volume's file says
  std::optional<Box3d> clip;

  bool operator==(const ObjectParts&) const = default;
};

/// One of several objects in a scene.
struct PlacedObject : ObjectParts {
  TransformParts transform;

  bool operator==(const PlacedObject&) const = default;
};

/// The fields as they are written. File names are relative to the scene file's folder. scene_fields.cpp has a
/// row for each field.
struct SceneFile : ObjectParts {
  std::vector<PlacedObject> objects;           ///< in place of the fields of ObjectParts; empty: a single one
  std::optional<UpAxis> up_axis;               ///< of world space, also for patients
  std::optional<std::uint32_t> width, height;  ///< both are set, or neither
  std::optional<std::uint32_t> antialias;
  CameraParts camera;
  std::vector<KeyFrameParts> camera_path;  ///< parts that a key frame leaves out are those of `camera`
  LightingParts lighting;
  std::optional<Vec3d> background;
  std::optional<bool> transparent;
  std::optional<double> samples;
  std::optional<double> detail;
  std::optional<bool> finest;

  bool operator==(const SceneFile&) const = default;
};

/// Reads a scene file of at most 16 MiB. An error is one line: "PATH: FIELD: what was expected, what was
/// found".
Result<SceneFile> read_scene(const std::string& path);

/// Reads a scene from a text. Errors have `name` in place of the path.
Result<SceneFile> parse_scene(const std::string& text, const std::string& name);

/// The text of a scene file with the fields that are set. Each list of numbers is on one line.
std::string to_json(const SceneFile& scene);

}  // namespace gvx::scene
