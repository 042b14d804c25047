#include "gvx/scene/scene_fields.h"

#include <array>
#include <string_view>

#include "gvx/scene/field_kinds.h"
#include "gvx/scene/scene_items.h"
#include "gvx/scene/scene_limits.h"
#include "gvx/scene/transform_fields.h"

namespace gvx::scene {
namespace {

constexpr NumberRange kPixels{1, 32768, true};
constexpr NumberRange kVoxels{1, 0x7fffffff, true};
constexpr NumberRange kComponents{1, kMaxChannels, true};
constexpr NumberRange kBytes{0, 0x1p53, true};
constexpr NumberRange kFrames{0, 0x1p31, true};
constexpr NumberRange kShininess{0, 10000};
constexpr NumberRange kRays{1, 8, true};
constexpr NumberRange kSamples{1, 1000};
constexpr NumberRange kDetail{0.25, 16};
constexpr NumberRange kLevels{1, 28, true};
constexpr NumberRange kResolution{1, 1 << 20, true};
constexpr NumberRange kOctaves{1, 32, true};
constexpr NumberRange kSeed{0, 4294967295.0, true};
constexpr NumberRange kLength{1e-6, 1e6};
constexpr NumberRange kStrength{0, 1000};
constexpr std::array<const char*, 10> kTypes = {"u8",  "i8",  "u16", "i16", "u32",
                                                "i32", "u64", "i64", "f32", "f64"};
constexpr std::array<const char*, 2> kByteOrders = {"little", "big"};

const FieldTable<RawParts>& raw_table() {
  static const FieldTable<RawParts> table = {
      numbers("dims", &RawParts::dimensions, kVoxels,
              {"--dims", "Voxels along X,Y,Z, of raw samples", kRawGroup,
               "three whole numbers above 0, as X,Y,Z"}),
      choice("dtype", &RawParts::type, kTypes,
             {"--dtype", "Type of raw samples: u8 i8 u16 i16 u32 i32 u64 i64 f32 f64", kRawGroup}),
      choice("endian", &RawParts::big_endian, kByteOrders,
             {"--endian", "Byte order of raw samples", kRawGroup}),
      number("components", &RawParts::components, kComponents,
             {"--components", "Numbers per voxel, of raw samples", kRawGroup}),
      number("offset", &RawParts::offset, kBytes,
             {"--offset", "Bytes before the first raw sample", kRawGroup}),
      numbers("spacing", &RawParts::spacing, kAboveZero,
              {"--spacing", "Size of a voxel along X,Y,Z, for any format", kRawGroup,
               "three numbers, as X,Y,Z"})};
  return table;
}

const FieldTable<GenerateParts>& generate_table() {
  using Parts = GenerateParts;
  static const FieldTable<Parts> table = {
      number("levels", &Parts::levels, kLevels, {"--levels", "Number of levels", kMadeGroup}),
      number("resolution", &Parts::resolution, kResolution,
             {"--resolution", "Voxels along the longest side of a mesh", kMadeGroup}),
      number("octaves", &Parts::octaves, kOctaves, {"--octaves", "Octaves of the noise", kMadeGroup}),
      number(
          "wavelength", &Parts::wavelength, kLength,
          {"--wavelength", "Wavelength of the first octave, as a fraction of the scene's cube", kMadeGroup}),
      number("gain", &Parts::gain, kShare,
             {"--gain", "Strength of an octave, relative to the one before", kMadeGroup}),
      number("seed", &Parts::seed, kSeed, {"--seed", "Random seed of the noise", kMadeGroup}),
      number("strength", &Parts::strength, kStrength, {"--strength", "Strength of the noise", kMadeGroup}),
      number("thickness", &Parts::thickness, kLength,
             {"--thickness", "Thickness of the shell around a surface, as a fraction of the scene's cube",
              kMadeGroup}),
      yes_or_no("inMarch", &Parts::in_march,
                {"--in-march",
                 "Compute noise, and densities from distances, at each sample of a ray instead of in bricks",
                 kMadeGroup})};
  return table;
}

const FieldTable<LightingParts>& lighting_table() {
  using Parts = LightingParts;
  static const FieldTable<Parts> table = {
      yes_or_no("enabled", &Parts::enabled,
                {"--shaded,!--flat", "Shade surfaces (default), or show colours without light"}),
      number("ambient", &Parts::ambient, kWeight,
             {"--ambient", "Weight of light from all sides (default: 0.25)"}),
      number("diffuse", &Parts::diffuse, kWeight,
             {"--diffuse", "Weight of light on surfaces that face it (default: 0.75)"}),
      number("specular", &Parts::specular, kWeight, {"--specular", "Weight of highlights (default: 0.2)"}),
      number("shininess", &Parts::shininess, kShininess,
             {"--shininess", "Exponent of highlights (default: 32)"}),
      custom<Parts>(
          "lights", [](JsonFields& fields, Parts& parts) { read_lights(fields, parts.lights); },
          [](WrittenJson& object, const Parts& parts) { write_lights(object, parts.lights); })};
  return table;
}

void read_clip(JsonFields& fields, std::optional<Box3d>& clip) {
  const auto row = fields.row("clip", std::vector<NumberRange>(6, kAny));
  if (!row) return;
  take_row(*row, clip.emplace());
  for (int axis = 0; axis < 3; ++axis) {
    if (clip->minimum[axis] < clip->maximum[axis]) continue;
    fields.fail(fields.place_of("clip"), "each minimum below its maximum", fields.any("clip")->dump());
  }
}

const FieldTable<ObjectParts>& object_table() {
  using Parts = ObjectParts;
  Field<Parts> clip =
      numbers("clip", &Parts::clip, kAny,
              {"--clip", "Show only this box: X0,Y0,Z0,X1,Y1,Z1 in fractions of the volume's size", "",
               "six numbers, as X0,Y0,Z0,X1,Y1,Z1"});
  clip.read = [](JsonFields& fields, Parts& parts) { read_clip(fields, parts.clip); };
  static const FieldTable<Parts> table = {
      text("volume", &Parts::volume, {"--volume", "The volume, in place of the one in the scene file"}),
      object("raw", &Parts::raw, raw_table()),
      text("series", &Parts::series,
           {"--series",
            "Series of a DICOM folder, by its number or UID (gvx info lists them); or image of an OME-TIFF "
            "file, counted from 1",
            kChoiceGroup}),
      number("time", &Parts::time, kFrames,
             {"--time", "Frame of a volume that changes with time, counted from 0", kChoiceGroup}),
      yes_or_no("evenSlices", &Parts::even_slices,
                {"--even-slices",
                 "Resample DICOM slices that are tilted, uneven or missing on an even, upright grid",
                 kChoiceGroup}),
      object("generate", &Parts::generate, generate_table()),
      choice("mode", &Parts::mode, kModeNames,
             {"--mode", "What a ray shows of the values along it (default: composite)"}),
      number("isovalue", &Parts::isovalue, kAny,
             {"--isovalue", "Physical value of the isosurface, for --mode isosurface"}),
      choice("classification", &Parts::classification, kClassificationNames,
             {"--classification",
              "preintegrated (default): each step along a ray shows all values between its ends; post: it "
              "shows only the value at its centre, which is faster but can miss thin layers"}),
      custom<Parts>(
          "functions", [](JsonFields& fields, Parts& parts) { read_functions(fields, parts.functions); },
          [](WrittenJson& object, const Parts& parts) { write_functions(object, parts.functions); }),
      custom<Parts>(
          "labels", [](JsonFields& fields, Parts& parts) { read_labels(fields, parts.labels); },
          [](WrittenJson& object, const Parts& parts) { write_labels(object, parts.labels); }),
      std::move(clip)};
  return table;
}

Result<PlacedObject> read_placed(const nlohmann::json& value, const std::string& place) {
  JsonFields fields(value, place);
  PlacedObject object;
  read_fields<ObjectParts>(fields, object_table(), object);
  read_transform(fields, object.transform);
  GVX_TRY(fields.finish());
  return object;
}

void read_objects(JsonFields& fields, SceneFile& scene) {
  read_items(fields, "objects", scene.objects, read_placed);
  if (scene.objects.empty() || static_cast<const ObjectParts&>(scene) == ObjectParts()) return;
  fields.fail(fields.place_of("objects"), "objects, or volume and the like", "both");
}

void write_objects(WrittenJson& document, const SceneFile& scene) {
  for (const PlacedObject& object : scene.objects) {
    WrittenJson parts = WrittenJson::object();
    write_fields<ObjectParts>(parts, object_table(), object);
    write_transform(parts, object.transform);
    document["objects"].push_back(std::move(parts));
  }
}

void read_size(JsonFields& fields, SceneFile& scene) {
  const auto size = fields.row("size", {kPixels, kPixels});
  if (!size) return;
  scene.width = static_cast<std::uint32_t>((*size)[0]);
  scene.height = static_cast<std::uint32_t>((*size)[1]);
}

void write_size(WrittenJson& object, const SceneFile& scene) {
  if (scene.width && scene.height) object["size"] = {*scene.width, *scene.height};
}

const FieldTable<SceneFile>& picture_table() {
  using Parts = SceneFile;
  static const FieldTable<Parts> table = {
      custom<Parts>("objects", read_objects, write_objects),
      choice(
          "upAxis", &Parts::up_axis, kUpAxisNames,
          {"--up", "The axis that points up (default: y for glTF, OBJ and PLY, z for STL and other scenes)"}),
      custom<Parts>("size", read_size, write_size,
                    {"--size", "Size of the picture in pixels, WxH (default: 1024x1024)", "",
                     "a size such as 1280x720"},
                    FieldForm::size),
      number("antialias", &Parts::antialias, kRays,
             {"--antialias", "N: take NxN rays for each pixel (default: 1)"}),
      custom<Parts>(
          "camera", [](JsonFields& fields, Parts& parts) { read_camera(fields, parts.camera); },
          [](WrittenJson& object, const Parts& parts) { write_camera(object, parts.camera); }),
      custom<Parts>(
          "cameraPath", [](JsonFields& fields, Parts& parts) { read_camera_path(fields, parts.camera_path); },
          [](WrittenJson& object, const Parts& parts) { write_camera_path(object, parts.camera_path); }),
      object("lighting", &Parts::lighting, lighting_table()),
      numbers("background", &Parts::background, kShare,
              {"--background",
               "RED,GREEN,BLUE from 0 to 1 (default: 0.13,0.16,0.2; 0,0,0 for maximum, minimum and mean)", "",
               "red,green,blue: three numbers such as 0.2,0.3,0.4"}),
      yes_or_no("transparent", &Parts::transparent,
                {"--transparent,!--opaque", "Keep the picture's alpha and draw no background"}),
      number("samples", &Parts::samples, kSamples,
             {"--samples", "Samples for each voxel along a ray (default: 2)"}),
      number("detail", &Parts::detail, kDetail,
             {"--detail",
              "Voxels across a pixel at which a level is chosen: 2 is sharp, 1 loads a quarter of the data "
              "(default: 2)"}),
      yes_or_no("finest", &Parts::finest,
                {"--finest,!--level-of-detail",
                 "Use the finest level everywhere, even if its voxels are much smaller than a pixel"})};
  return table;
}

template <typename Parts>
void describe_table(const FieldTable<Parts>& table, std::vector<FieldDescription>& all) {
  for (const Field<Parts>& field : table) {
    if (field.inner.empty()) all.push_back(field.about);
    all.insert(all.end(), field.inner.begin(), field.inner.end());
  }
}

}  // namespace

std::string FieldDescription::flag_name() const {
  const std::string_view names = flag.names == nullptr ? "" : flag.names;
  return std::string(names.substr(0, names.find(',')));
}

const std::vector<FieldDescription>& scene_fields() {
  static const std::vector<FieldDescription> fields = [] {
    std::vector<FieldDescription> all;
    describe_table(object_table(), all);
    describe_table(picture_table(), all);
    return all;
  }();
  return fields;
}

Status read_over(const nlohmann::json& document, SceneFile& scene) {
  JsonFields fields(document, "");
  read_fields<ObjectParts>(fields, object_table(), scene);
  read_fields(fields, picture_table(), scene);
  return fields.finish();
}

std::vector<std::string> set_fields(const GenerateParts& parts) {
  WrittenJson object = WrittenJson::object();
  write_fields(object, generate_table(), parts);
  std::vector<std::string> names;
  for (const auto& field : object.items()) names.push_back(field.key());
  return names;
}

nlohmann::ordered_json to_document(const SceneFile& scene) {
  WrittenJson document = WrittenJson::object();
  write_fields<ObjectParts>(document, object_table(), scene);
  write_fields(document, picture_table(), scene);
  return document;
}

}  // namespace gvx::scene
