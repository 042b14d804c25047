#include "gvx/open/temporary_store.h"

#include <filesystem>
#include <system_error>
#include <vector>

#include "gvx/io/mesh.h"
#include "gvx/io/scratch_file.h"
#include "gvx/io/store_build.h"
#include "gvx/io/volume_reader.h"
#include "gvx/open/build_warnings.h"
#include "gvx/open/mesh_store.h"
#include "gvx/scene/scene_fields.h"

namespace gvx::open {
namespace {

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

/// A temporary file, and the folder that it is in.
struct Place {
  std::string path, folder;
};

Status build_from_mesh(const std::string& path, const Place& store, scene::GenerateParts& parts,
                       const OpenOptions& options) {
  MeshBuild build;
  build.store.resolution = parts.resolution.value_or(build.store.resolution);
  parts.resolution.reset();
  build.store.codec = store::Codec::lz4;
  build.scratch_folder = store.folder;
  GVX_TRY(check_all_taken(path, parts));
  GVX_TRY(options.before_build({VoxelType::u8, VoxelContent::color_normal, 7}));
  GVX_ASSIGN(const BuiltMesh built, build_mesh(path, store.path, std::move(build), options));
  (void)built;
  return {};
}

Status build_from_volume(const std::string& path, const Place& store, const io::VolumeOptions& volume_options,
                         const scene::GenerateParts& parts, const OpenOptions& options) {
  GVX_ASSIGN(const auto volume, io::open_volume(path, volume_options));
  GVX_TRY(check_all_taken(path, parts));
  io::StoreBuildOptions build;
  build.labels = volume_options.labels.value_or(volume->description().labels);
  GVX_TRY(options.before_build(format_of(volume->description(), build.labels)));
  build.codec = store::Codec::lz4;
  build.memory_bytes = 4ull << 30;
  const auto show = [&](std::uint64_t done, std::uint64_t all) {
    options.show_work({"building", Work::Unit::bytes, done, all});
  };
  GVX_ASSIGN(const auto report, io::build_store(options.cpu, *volume, store.path, build, show));
  warn_of_build(path, volume->description(), report, options.warn);
  return {};
}

/// Has build(place) write a store without a name, and opens it. Errors that name it say what it is.
template <typename Reader, typename Build>
Result<std::unique_ptr<Reader>> open_built(const Build& build) {
  std::error_code error;
  const std::string folder = std::filesystem::temp_directory_path(error).string();
  if (error) return Error{"the folder for temporary files (TMPDIR): " + error.message()};
  GVX_ASSIGN(const io::ScratchFile file, io::ScratchFile::create(folder));
  const Place place{file.path(), folder};
  const auto in_words = [&](const Error& failure) {
    const bool of_store = failure.message.starts_with(place.path);
    return of_store ? Error{"temporary store in " + folder + failure.message.substr(place.path.size())}
                    : failure;
  };
  const Status built = build(place);
  if (!built.ok()) return in_words(built.error());
  auto reader = Reader::open(place.path);
  if (!reader.ok()) return in_words(reader.error());
  return reader;
}

}  // namespace

Result<std::unique_ptr<store::StoreReader>> open_temporary_store(const std::string& path,
                                                                 const io::VolumeOptions& volume_options,
                                                                 scene::GenerateParts parts,
                                                                 const OpenOptions& options) {
  return open_built<store::StoreReader>([&](const Place& place) {
    return io::is_mesh_name(path) ? build_from_mesh(path, place, parts, options)
                                  : build_from_volume(path, place, volume_options, parts, options);
  });
}

Result<std::unique_ptr<surface::SurfaceReader>> open_temporary_surface(const std::string& path,
                                                                       const OpenOptions& options) {
  return open_built<surface::SurfaceReader>([&](const Place& place) -> Status {
    MeshBuild build;
    build.store.codec = store::Codec::lz4;
    build.scratch_folder = place.folder;
    GVX_ASSIGN(const BuiltSurface built, build_mesh_surface(path, place.path, build, options));
    (void)built;
    return {};
  });
}

Status check_all_taken(const std::string& name, const scene::GenerateParts& left) {
  const std::vector<std::string> fields = scene::set_fields(left);
  if (fields.empty()) return {};
  return Error{name + ": " + fields.front() + " does not apply to this scene"};
}

}  // namespace gvx::open
