#include "gvx/open/open_volume.h"

#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "gvx/io/mesh.h"
#include "gvx/io/sample_type.h"
#include "gvx/io/tiff.h"
#include "gvx/open/closest_word.h"
#include "gvx/open/made_scenes.h"
#include "gvx/open/temporary_store.h"
#include "gvx/produce/amplify_producer.h"
#include "gvx/produce/deeper_producer.h"
#include "gvx/produce/repeat_producer.h"
#include "gvx/produce/store_producer.h"
#include "gvx/render/frame/view.h"
#include "gvx/scene/transfer_presets.h"
#include "gvx/store/store_reader.h"
#include "gvx/surface/stored_surface.h"

namespace gvx::open {
namespace {

/// What all parts of a name are opened with.
struct Request {
  io::VolumeOptions volume;
  const OpenOptions& options;
  bool meshes_are_surfaces = false;
};

/// A store, or what another program's file becomes, which takes what is left of `parts`.
Result<std::unique_ptr<store::StoreReader>> open_store(const Request& request, const std::string& name,
                                                       scene::GenerateParts& parts) {
  GVX_ASSIGN(const bool store, is_store(name));
  if (!store) return open_temporary_store(name, request.volume, std::exchange(parts, {}), request.options);
  GVX_ASSIGN(auto reader, store::StoreReader::open(name));
  if (reader->info().border < std::uint32_t{kBrickBorder} &&
      reader->info().format.content == VoxelContent::scalar) {
    request.options.warn(
        name +
        ": was built by an older gvx: surfaces are a little less smooth at the faces of bricks than those "
        "of a store that is built anew");
  }
  return reader;
}

/// The surface of a store, or of a mesh where it is to be shown as such; nothing where the name is another's.
Result<std::optional<OpenVolume>> open_surface(const Request& request, const std::string& name,
                                               const scene::GenerateParts& parts) {
  std::unique_ptr<surface::SurfaceReader> reader;
  if (surface::is_surface_store(name)) {
    GVX_ASSIGN(reader, surface::SurfaceReader::open(name));
  } else if (request.meshes_are_surfaces && io::is_mesh_name(name) && !parts.resolution) {
    GVX_TRY(check_all_taken(name, parts));
    GVX_ASSIGN(reader, open_temporary_surface(name, request.options));
  } else {
    return std::optional<OpenVolume>();
  }
  GVX_ASSIGN(auto surface, surface::StoredSurface::of(std::move(reader)));
  return std::optional(OpenVolume{std::move(surface), {}});
}

/// A name, with what was said of it that no scene has taken yet.
Result<OpenVolume> open_part(const Request& request, const std::string& name, scene::GenerateParts& parts);

Status check_voxels(const OpenVolume& volume, const std::string& name, const char* scene) {
  if (!volume.producer->description().surface) return {};
  return Error{name + ": " + scene + ": it is a surface; expected a volume"};
}

/// COPIES:SCENE, or SCENE, which is shown 8 times along each axis.
Result<OpenVolume> open_repeated(const Request& request, std::string name, scene::GenerateParts& parts) {
  std::int64_t copies = 8;
  const std::size_t digits = name.find_first_not_of("0123456789");
  if (digits > 0 && digits != std::string::npos && name[digits] == ':') {
    copies = digits < 10 ? std::stoll(name.substr(0, digits)) : 0;
    name = name.substr(digits + 1);
    if (copies < 2 || !std::has_single_bit(static_cast<std::uint64_t>(copies))) {
      return Error{"repeat: the number of copies along an axis must be a power of 2, from 2 on"};
    }
  }
  GVX_ASSIGN(OpenVolume one, open_part(request, name, parts));
  GVX_TRY(check_voxels(one, name, "repeat"));
  const auto levels = static_cast<std::uint32_t>(std::countr_zero(static_cast<std::uint64_t>(copies)));
  auto many = produce::RepeatProducer::create(std::move(one.producer), levels);
  if (!many.ok()) return Error{name + ": " + many.error().message};
  // Noise is told in the whole's cube.
  if (one.noise) return Error{name + ": repeat: noise in the march cannot be repeated"};
  return OpenVolume{std::move(many).value(), one.preset};
}

/// Rays amplify the volume as they go through it.
Result<OpenVolume> add_noise_in_march(OpenVolume volume, const std::string& name,
                                      const produce::AmplifyOptions& options) {
  if (volume.noise) return Error{name + ": amplify: rays can add noise but once"};
  const AddedNoise noise = produce::amplification(volume.producer->description(), options);
  auto deeper = produce::DeeperProducer::create(std::move(volume.producer), options.levels);
  if (!deeper.ok()) return Error{name + ": amplify: " + deeper.error().message};
  return OpenVolume{std::move(deeper).value(), volume.preset, noise};
}

Result<OpenVolume> open_amplified(const Request& request, const std::string& name,
                                  scene::GenerateParts& parts) {
  produce::AmplifyOptions options;
  options.levels = static_cast<std::uint32_t>(parts.levels.value_or(options.levels));
  options.strength = parts.strength.value_or(options.strength);
  options.gain = parts.gain.value_or(options.gain);
  options.seed = static_cast<std::uint32_t>(parts.seed.value_or(options.seed));
  parts.levels.reset(), parts.seed.reset();
  parts.strength.reset(), parts.gain.reset();
  const bool in_march = parts.in_march.value_or(false);
  parts.in_march.reset();
  GVX_ASSIGN(OpenVolume one, open_part(request, name, parts));
  GVX_TRY(check_voxels(one, name, "amplify"));
  if (in_march) return add_noise_in_march(std::move(one), name, options);
  auto rich = produce::AmplifyProducer::create(std::move(one.producer), options);
  if (!rich.ok()) return Error{name + ": " + rich.error().message};
  return OpenVolume{std::move(rich).value(), one.preset, one.noise};
}

Result<OpenVolume> open_part(const Request& request, const std::string& name, scene::GenerateParts& parts) {
  Request of_voxels = request;
  of_voxels.meshes_are_surfaces = false;
  if (name.starts_with("repeat:")) return open_repeated(of_voxels, name.substr(7), parts);
  if (name.starts_with("amplify:")) return open_amplified(of_voxels, name.substr(8), parts);
  GVX_ASSIGN(std::optional<OpenVolume> built_in, open_made_scene(request.options.render, name, parts));
  if (built_in) return std::move(*built_in);
  std::error_code ignored;
  if (!std::filesystem::exists(name, ignored)) {
    const std::vector<std::string> made = {"sponge", "stored-sponge", "cloud", "terrain"};
    if (const auto near = closest_word(name, made)) {
      return Error{name + ": neither a file nor a made scene; did you mean " + *near + "?"};
    }
  }
  GVX_ASSIGN(std::optional<OpenVolume> surface, open_surface(request, name, parts));
  if (surface) return std::move(*surface);
  GVX_ASSIGN(auto reader, open_store(request, name, parts));
  auto producer = std::make_shared<produce::StoreProducer>(std::move(reader));
  const std::string preset = scene::suggest_preset(value_statistics(producer->description(), 0));
  return OpenVolume{std::move(producer), preset};
}

/// Does the scene cut anything of the object off?
bool clips(const scene::ObjectParts& object) {
  return object.clip && *object.clip != render::ObjectLook().clip;
}

/// An error where a surface is to be shown as only volumes are.
Status check_surface(const scene::ObjectParts& object, const OpenVolume& opened) {
  if (!opened.producer->description().surface) return {};
  const std::string& name = *object.volume;
  if (object.mode.value_or(scene::Mode::composite) != scene::Mode::composite)
    return Error{name + ": mode: a surface is shown as it is; expected composite"};
  if (clips(object)) return Error{name + ": clip: surfaces are not clipped yet; expected none"};
  return {};
}

}  // namespace

Result<OpenVolume> open_volume(const scene::ObjectParts& object, const OpenOptions& options) {
  if (!object.volume) return Error{"volume: expected the name of a volume, found nothing"};
  scene::GenerateParts parts = object.generate;
  Request request{volume_options(object), options};
  request.meshes_are_surfaces = object.mode.value_or(scene::Mode::composite) == scene::Mode::composite &&
                                !clips(object) && options.render.kind() == exec::DeviceKind::cpu;
  GVX_ASSIGN(OpenVolume opened, open_part(request, *object.volume, parts));
  GVX_TRY(check_surface(object, opened));
  GVX_TRY(check_all_taken(*object.volume, parts));
  return opened;
}

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
  return magic == store::kMagic || magic == surface::kSurfaceMagic || path.ends_with(".gvx");
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

io::VolumeOptions volume_options(const scene::ObjectParts& object) {
  io::VolumeOptions options;
  options.raw.dimensions = object.raw.dimensions;
  if (object.raw.type) options.raw.type = io::parse_sample_type(*object.raw.type);
  options.raw.big_endian = object.raw.big_endian;
  options.raw.offset = object.raw.offset;
  options.raw.spacing = object.raw.spacing;
  options.raw.components = object.raw.components;
  options.series = object.series;
  options.time = object.time;
  if (object.labels) options.labels = object.labels->enabled;
  options.even_slices = object.even_slices.value_or(false);
  return options;
}

}  // namespace gvx::open
