#include "open_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "build_report.h"
#include "built_in_scenes.h"
#include "command_line.h"
#include "commands.h"
#include "gvx/io/mesh.h"
#include "gvx/io/scratch_file.h"
#include "gvx/io/store_build.h"
#include "gvx/io/tiff.h"
#include "gvx/io/volume_reader.h"
#include "gvx/produce/amplify_producer.h"
#include "gvx/produce/deeper_producer.h"
#include "gvx/produce/repeat_producer.h"
#include "gvx/produce/store_producer.h"
#include "gvx/scene/transfer_presets.h"
#include "gvx/store/store_reader.h"
#include "mesh_build.h"
#include "messages.h"
#include "progress.h"
#include "units.h"

namespace gvx::app {
namespace {

/// An error where something was said of a scene that it does not take.
Status check_all_taken(const std::string& name, const scene::GenerateParts& parts) {
  for (const auto& [left, what] : {std::pair{parts.levels.has_value(), "levels"},
                                   {parts.resolution.has_value(), "resolution"},
                                   {parts.octaves.has_value(), "octaves"},
                                   {parts.seed.has_value(), "seed"},
                                   {parts.wavelength.has_value(), "wavelength"},
                                   {parts.gain.has_value(), "gain"},
                                   {parts.strength.has_value(), "strength"},
                                   {parts.thickness.has_value(), "thickness"},
                                   {parts.in_march.has_value(), "inMarch"}}) {
    if (left) return Error{name + ": " + what + " does not apply to this scene"};
  }
  return {};
}

/// Of what a file becomes before it is shown.
VoxelFormat format_of(const io::VolumeDescription& volume, bool labels) {
  if (labels) return {VoxelType::u16, VoxelContent::labels, 1};
  if (volume.colors) return {VoxelType::u8, VoxelContent::color, 4};
  const std::size_t bytes = io::sample_bytes(volume.type);
  return {bytes == 1   ? VoxelType::u8
          : bytes == 2 ? VoxelType::u16
                       : VoxelType::f32,
          VoxelContent::scalar, static_cast<std::uint32_t>(volume.components)};
}

Status fill_store(const Devices& devices, const std::string& path, const io::VolumeOptions& volume_options,
                  scene::GenerateParts& parts, const BeforeBuild& before_build, const std::string& folder,
                  const std::string& store_path) {
  const std::string title = "building a temporary store (gvx build keeps it)";
  if (io::is_mesh_name(path)) {
    mesh::MeshStoreOptions options;
    if (parts.resolution) options.resolution = *parts.resolution;
    parts.resolution.reset();
    options.codec = store::Codec::lz4;
    GVX_TRY(check_all_taken(path, parts));
    GVX_TRY(before_build({VoxelType::u8, VoxelContent::color_normal, 7}));
    GVX_ASSIGN(const auto report,
               build_mesh(devices.cpu, path, store_path, options, MeshFlags::Fill::automatic, std::nullopt,
                          title + ": ", folder, devices.quiet));
    (void)report;
    return {};
  }
  GVX_ASSIGN(const auto volume, io::open_volume(path, volume_options));
  GVX_TRY(check_all_taken(path, parts));
  io::StoreBuildOptions options;
  options.labels = volume_options.labels.value_or(volume->description().labels);
  GVX_TRY(before_build(format_of(volume->description(), options.labels)));
  options.codec = store::Codec::lz4;
  options.memory_bytes = 4ull << 30;
  io::StoreBuildReport report;
  {
    Progress progress(title, Progress::Unit::bytes, devices.quiet);
    const auto show = [&](std::uint64_t done, std::uint64_t all) { progress.show(done, all); };
    GVX_ASSIGN(report, io::build_store(devices.cpu, *volume, store_path, options, show));
  }
  warn_of_build(path, volume->description(), report);
  return {};
}

/// Builds a store that never has a name, so that nothing is left behind however the program ends.
Result<std::unique_ptr<store::StoreReader>> build_nameless_store(const Devices& devices,
                                                                 const std::string& path,
                                                                 const io::VolumeOptions& volume_options,
                                                                 scene::GenerateParts& parts,
                                                                 const BeforeBuild& before_build) {
  std::error_code error;
  const std::string folder = std::filesystem::temp_directory_path(error).string();
  if (error) return Error{"the folder for temporary files (TMPDIR): " + error.message()};
  GVX_ASSIGN(const io::ScratchFile file, io::ScratchFile::create(folder));
  const std::string store_path = file.path();
  const auto in_words = [&](const Error& failure) {
    const bool of_store = failure.message.starts_with(store_path);
    return of_store ? Error{"temporary store in " + folder + failure.message.substr(store_path.size())}
                    : failure;
  };
  const Status filled = fill_store(devices, path, volume_options, parts, before_build, folder, store_path);
  if (!filled.ok()) return in_words(filled.error());
  auto reader = store::StoreReader::open(store_path);
  if (!reader.ok()) return in_words(reader.error());
  return reader;
}

}  // namespace

Result<bool> is_store(const std::string& path) {
  if (path == "-") return false;
  std::error_code ignored;
  // A folder or a pattern, of slices.
  if (std::filesystem::is_directory(path, ignored) || io::is_tiff(path)) return false;
  // To look into a pipe would take away what is in it.
  if (std::filesystem::is_fifo(path, ignored)) return path.ends_with(".gvx");
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path + ": cannot open: " + std::strerror(errno)};
  std::array<char, 8> magic{};
  file.read(magic.data(), magic.size());
  return magic == store::kMagic || path.ends_with(".gvx");
}

scene::ValueStatistics value_statistics(const produce::TreeDescription& tree, std::size_t channel) {
  scene::ValueStatistics statistics = scene::physical_statistics(
      tree.ranges.channel[channel],
      channel < tree.histograms.size() ? tree.histograms[channel] : std::vector<std::uint64_t>{}, tree.scale,
      tree.offset);
  statistics.anatomical = tree.anatomical;
  statistics.channel = static_cast<std::uint32_t>(channel);
  statistics.channels = tree.format.channels();
  if (channel < tree.channel_colors.size() && tree.channel_colors[channel]) {
    statistics.color = Vec3d(*tree.channel_colors[channel]);
  }
  const Vec3d size = tree.extent.maximum - tree.extent.minimum;
  statistics.size_world = std::cbrt(std::abs(determinant(tree.tree_to_world)) * size.x * size.y * size.z);
  return statistics;
}

namespace {

/// What is typed, with what was said of it that no scene has taken yet.
Result<Scene> open_part(const Devices& devices, const std::string& name,
                        const io::VolumeOptions& volume_options, scene::GenerateParts& parts,
                        const BeforeBuild& before_build);

/// COPIES:SCENE, or SCENE, which is shown 8 times along each axis.
Result<Scene> open_repeated(const Devices& devices, std::string name, const io::VolumeOptions& volume_options,
                            scene::GenerateParts& parts, const BeforeBuild& before_build) {
  std::int64_t copies = 8;
  const std::size_t digits = name.find_first_not_of("0123456789");
  if (digits > 0 && digits != std::string::npos && name[digits] == ':') {
    copies = digits < 10 ? std::stoll(name.substr(0, digits)) : 0;
    name = name.substr(digits + 1);
    if (copies < 2 || !std::has_single_bit(static_cast<std::uint64_t>(copies))) {
      return Error{"repeat: the number of copies along an axis must be a power of 2, from 2 on"};
    }
  }
  GVX_ASSIGN(Scene one, open_part(devices, name, volume_options, parts, before_build));
  const auto levels = static_cast<std::uint32_t>(std::countr_zero(static_cast<std::uint64_t>(copies)));
  auto many = produce::RepeatProducer::create(std::move(one.producer), levels);
  if (!many.ok()) return Error{name + ": " + many.error().message};
  // Noise is told in the whole's cube.
  if (one.noise) return Error{name + ": repeat: noise in the march cannot be repeated"};
  return Scene{std::move(many).value(), one.preset};
}

/// Rays amplify the volume as they go through it.
Result<Scene> add_noise_in_march(Scene volume, const std::string& name,
                                 const produce::AmplifyOptions& options) {
  if (volume.noise) return Error{name + ": amplify: rays can add noise but once"};
  const AddedNoise noise = produce::amplification(volume.producer->description(), options);
  auto deeper = produce::DeeperProducer::create(std::move(volume.producer), options.levels);
  if (!deeper.ok()) return Error{name + ": amplify: " + deeper.error().message};
  return Scene{std::move(deeper).value(), volume.preset, noise};
}

Result<Scene> open_amplified(const Devices& devices, const std::string& name,
                             const io::VolumeOptions& volume_options, scene::GenerateParts& parts,
                             const BeforeBuild& before_build) {
  produce::AmplifyOptions options;
  options.levels = static_cast<std::uint32_t>(parts.levels.value_or(options.levels));
  options.strength = parts.strength.value_or(options.strength);
  options.gain = parts.gain.value_or(options.gain);
  options.seed = static_cast<std::uint32_t>(parts.seed.value_or(options.seed));
  parts.levels.reset(), parts.seed.reset();
  parts.strength.reset(), parts.gain.reset();
  const bool in_march = parts.in_march.value_or(false);
  parts.in_march.reset();
  GVX_ASSIGN(Scene one, open_part(devices, name, volume_options, parts, before_build));
  if (in_march) return add_noise_in_march(std::move(one), name, options);
  auto rich = produce::AmplifyProducer::create(std::move(one.producer), options);
  if (!rich.ok()) return Error{name + ": " + rich.error().message};
  return Scene{std::move(rich).value(), one.preset, one.noise};
}

Result<Scene> open_part(const Devices& devices, const std::string& name,
                        const io::VolumeOptions& volume_options, scene::GenerateParts& parts,
                        const BeforeBuild& before_build) {
  if (name.starts_with("repeat:"))
    return open_repeated(devices, name.substr(7), volume_options, parts, before_build);
  if (name.starts_with("amplify:"))
    return open_amplified(devices, name.substr(8), volume_options, parts, before_build);
  GVX_ASSIGN(std::optional<Scene> built_in, open_built_in_scene(devices.render, name, parts));
  if (built_in) return std::move(*built_in);
  std::error_code ignored;
  if (!std::filesystem::exists(name, ignored)) {
    const std::vector<std::string> made = {"sponge", "stored-sponge", "cloud", "terrain"};
    if (const auto near = closest(name, made)) {
      return Error{name + ": neither a file nor a made scene; did you mean " + *near + "?"};
    }
  }
  GVX_ASSIGN(const bool store, is_store(name));
  std::unique_ptr<store::StoreReader> reader;
  if (store) {
    GVX_ASSIGN(reader, store::StoreReader::open(name));
    if (reader->info().border < std::uint32_t{kBrickBorder} &&
        reader->info().format.content == VoxelContent::scalar) {
      warn(name +
           ": was built by an older gvx: surfaces are a little less smooth at the faces of bricks than those "
           "of a store that is built anew");
    }
  } else {
    GVX_ASSIGN(reader, build_nameless_store(devices, name, volume_options, parts, before_build));
  }
  auto producer = std::make_shared<produce::StoreProducer>(std::move(reader));
  const std::string preset = scene::suggest_preset(value_statistics(producer->description(), 0));
  return Scene{std::move(producer), preset};
}

}  // namespace

Result<Scene> open_scene(const Devices& devices, const std::string& name,
                         const io::VolumeOptions& volume_options, scene::GenerateParts parts,
                         const BeforeBuild& before_build) {
  GVX_ASSIGN(Scene opened, open_part(devices, name, volume_options, parts, before_build));
  GVX_TRY(check_all_taken(name, parts));
  return opened;
}

void VolumeFlags::add_to(CLI::App& command) {
  const char* group = "Raw input";
  command.add_option("--dims", dims_, "Voxels along X,Y,Z, of raw samples")->group(group);
  command.add_option("--dtype", dtype_, "Type of raw samples: u8 i8 u16 i16 u32 i32 u64 i64 f32 f64")
      ->group(group);
  command.add_option("--endian", endian_, "Byte order of raw samples: little or big")->group(group);
  command.add_option("--components", components_, "Numbers per voxel, of raw samples")
      ->check(CLI::Range(1, 4))
      ->group(group);
  command.add_option("--offset", offset_, "Bytes before the first raw sample")->group(group);
  command.add_option("--spacing", spacing_, "Size of a voxel along X,Y,Z, for any format")->group(group);
  const char* choice = "Volumes with several series or frames";
  command
      .add_option("--series", series_,
                  "Series of a DICOM folder, by its number or UID (gvx info lists them); or image of an "
                  "OME-TIFF file, counted from 1")
      ->check(not_empty())
      ->group(choice);
  command.add_option("--time", time_, "Frame of a volume that changes with time, counted from 0")
      ->check(CLI::NonNegativeNumber)
      ->group(choice);
  command
      .add_flag("--even-slices", even_slices_,
                "Resample DICOM slices that are tilted, uneven or missing on an even, upright grid")
      ->group(choice);
}

bool VolumeFlags::given() const {
  return !dims_.empty() || !dtype_.empty() || !endian_.empty() || !spacing_.empty() || offset_ ||
         components_ || !series_.empty() || time_ || even_slices_;
}

Error VolumeFlags::refuse(const std::string& path, const char* what) {
  return Error{path +
               ": --dims, --dtype, --endian, --components, --offset, --spacing, --series, --time and "
               "--even-slices do not apply to " +
               what};
}

Result<io::VolumeOptions> VolumeFlags::parse() const {
  io::VolumeOptions options;
  io::RawOptions& raw = options.raw;
  if (!series_.empty()) options.series = series_;
  options.time = time_;
  options.even_slices = even_slices_;
  raw.offset = offset_;
  raw.components = components_;
  if (!dims_.empty()) {
    GVX_ASSIGN(raw.dimensions, in_flag("--dims", parse_dimensions(dims_)));
  }
  if (!dtype_.empty()) {
    raw.type = io::parse_sample_type(dtype_);
    if (!raw.type) return Error{"--dtype: '" + dtype_ + "' is not one of " + io::kSampleTypeNames};
  }
  if (!endian_.empty()) {
    if (endian_ != "little" && endian_ != "big")
      return Error{"--endian: '" + endian_ + "' is not little or big"};
    raw.big_endian = endian_ == "big";
  }
  if (!spacing_.empty()) {
    GVX_ASSIGN(raw.spacing, in_flag("--spacing", parse_vec3(spacing_)));
  }
  return options;
}

}  // namespace gvx::app
