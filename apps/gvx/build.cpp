// gvx build INPUT -o OUT.gvx: a volume or mesh file into a store.

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <vector>

#include "commands.h"
#include "field_flags.h"
#include "gvx/io/channel_merger.h"
#include "gvx/io/mesh.h"
#include "gvx/io/store_build.h"
#include "gvx/io/volume_reader.h"
#include "gvx/open/build_warnings.h"
#include "gvx/open/file_names.h"
#include "gvx/open/mesh_store.h"
#include "mesh_flags.h"
#include "messages.h"
#include "outputs.h"
#include "progress.h"
#include "units.h"
#include "work_bar.h"

namespace gvx::app {
namespace {

struct Options {
  std::vector<std::string> inputs;
  std::string output, memory = "1G", codec = "zstd", type;
  int brick = 16, tree = 2, threads = 0;
  bool force = false, labels = false;
  CLI::Option* labels_option = nullptr;
  CLI::Option *brick_option = nullptr, *tree_option = nullptr;
  VolumeFlags volume;
  MeshFlags mesh;

  bool of_voxels() const { return brick_option->count() + tree_option->count() > 0; }
};

void print_built(const std::string& path, Vec3i d, std::uint64_t bytes) {
  std::printf("%s: %lld x %lld x %lld voxels, %s\n", one_line(path).c_str(), static_cast<long long>(d.x),
              static_cast<long long>(d.y), static_cast<long long>(d.z), bytes_text(bytes).c_str());
}

void print_built(const std::string& path, const open::BuiltSurface& built) {
  std::printf("%s: a surface of %llu triangles: %llu bricks in %u levels, %llu samples, %s\n",
              one_line(path).c_str(), static_cast<unsigned long long>(built.triangles),
              static_cast<unsigned long long>(built.store.bricks), built.store.levels,
              static_cast<unsigned long long>(built.store.samples),
              bytes_text(built.store.bytes_written).c_str());
}

Status build_from_mesh(const Options& o, const io::StoreBuildOptions& common) {
  const std::string& path = o.inputs.front();
  if (o.inputs.size() > 1)
    return Error{path + ": a store takes one mesh; several files are for the channels of a volume"};
  if (o.labels || !o.type.empty()) return Error{path + ": --labels and --type do not go with a mesh"};
  if (o.volume.given()) return VolumeFlags::refuse(path);
  open::MeshBuild mesh = o.mesh.parse();
  mesh.store.n = common.n;
  mesh.store.m = common.m;
  mesh.store.codec = common.codec;
  mesh.store.memory_bytes = common.memory_bytes;
  WorkBar bar("", false);
  open::OpenOptions options;
  options.cpu = exec::Device::cpu(o.threads);
  options.warn = [&](const std::string& message) {
    bar.clear();
    warn(message);
  };
  options.show_work = [&](const open::Work& work) { bar.show(work); };
  // Its advice names flags.
  options.naming = open::FieldNaming([](const std::string&) { return std::string(); });
  GVX_ASSIGN(const bool surface, o.mesh.as_surface());
  io::MeshUp up;
  if (surface) {
    if (o.of_voxels()) return Error{path + ": --brick and --tree are for voxels (--as voxels)"};
    GVX_ASSIGN(const open::BuiltSurface built, open::build_mesh_surface(path, o.output, mesh, options));
    bar.clear();
    print_built(o.output, built);
    up = built.up;
  } else {
    GVX_ASSIGN(const open::BuiltMesh built, open::build_mesh(path, o.output, mesh, options));
    bar.clear();
    print_built(o.output, built.store.dimensions, built.store.bytes_written);
    up = built.up;
  }
  const std::string note = mesh.up ? "" : up_note(path, up);
  if (!note.empty()) std::printf("%s\n", one_line(note).c_str());
  return {};
}

/// One volume, or several as its channels.
Result<std::unique_ptr<io::SliceReader>> open_channels(const std::vector<std::string>& paths,
                                                       const io::VolumeOptions& volume_options) {
  std::vector<std::unique_ptr<io::SliceReader>> volumes;
  for (const std::string& path : paths) {
    GVX_ASSIGN(volumes.emplace_back(), io::open_volume(path, volume_options));
  }
  if (volumes.size() == 1) return std::unique_ptr<io::SliceReader>(std::move(volumes.front()));
  GVX_ASSIGN(std::unique_ptr<io::SliceReader> merged, io::ChannelMerger::merge(std::move(volumes)));
  return merged;
}

Status check_output(const Options& o, const io::VolumeOptions& volume_options) {
  const Output output{"-o", o.output};
  GVX_TRY(check_outputs({&output, 1}, [&] {
    std::vector<std::string> files;
    for (const std::string& input : o.inputs) {
      const std::vector<std::string> parts = open::files_of(input, volume_options);
      files.insert(files.end(), parts.begin(), parts.end());
    }
    return files;
  }));
  if (!o.output.ends_with(".gvx")) return Error{"-o " + o.output + ": a store's name must end in .gvx"};
  GVX_TRY(check_is_file(output));
  std::error_code error;
  if (!o.force && std::filesystem::exists(o.output, error)) {
    return Error{o.output + ": already exists (--force replaces it)"};
  }
  return {};
}

Status build(const Options& o) {
  GVX_ASSIGN(const io::VolumeOptions volume_options, o.volume.parse());
  GVX_TRY(check_output(o, volume_options));
  const std::map<std::string, store::Codec> codecs = {
      {"zstd", store::Codec::zstd}, {"lz4", store::Codec::lz4}, {"none", store::Codec::none}};
  const std::map<std::string, VoxelType> types = {
      {"u8", VoxelType::u8}, {"u16", VoxelType::u16}, {"f32", VoxelType::f32}};
  io::StoreBuildOptions options;
  options.n = static_cast<std::uint32_t>(o.tree);
  options.m = static_cast<std::uint32_t>(o.brick);
  options.codec = codecs.at(o.codec);
  if (!o.type.empty()) options.type = types.at(o.type);
  GVX_ASSIGN(options.memory_bytes, in_flag("--memory", parse_bytes(o.memory)));
  if (io::is_mesh_name(o.inputs.front())) return build_from_mesh(o, options);
  if (o.mesh.given()) return Error{o.inputs.front() + ": --as, --resolution, --fill and --up are for meshes"};
  GVX_ASSIGN(const auto volume, open_channels(o.inputs, volume_options));
  options.labels = o.labels_option->count() > 0 ? o.labels : volume->description().labels && !options.type;
  io::StoreBuildReport report;
  {
    Progress progress("building", Progress::Unit::bytes);
    GVX_ASSIGN(report,
               io::build_store(exec::Device::cpu(o.threads), *volume, o.output, options,
                               [&](std::uint64_t done, std::uint64_t all) { progress.show(done, all); }));
  }
  print_built(o.output, volume->description().dimensions, report.bytes_written);
  open::warn_of_build(o.inputs.front(), volume->description(), report, warn);
  return {};
}

}  // namespace

Command add_build(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("build", "Save a volume or mesh as a .gvx store");
  command
      ->add_option(
          "input", options->inputs,
          "A DICOM, TIFF, NIfTI, NRRD, MetaImage or RAW file; a folder of DICOM files or TIFF slices; a "
          "pattern such as 'z*.tif'; or a mesh (PLY, OBJ, STL, glTF). - reads raw samples from a pipe. "
          "Two to four files of one shape become the channels of one volume")
      ->required()
      ->expected(1, 4);
  command->add_option("-o,--output", options->output, "The store to write; its name ends in .gvx")
      ->required();
  options->brick_option = command->add_option("--brick", options->brick, "Voxels along an edge of a brick")
                              ->check(CLI::IsMember({8, 16, 32}))
                              ->capture_default_str();
  options->tree_option =
      command->add_option("--tree", options->tree, "Factor between the resolutions of two levels")
          ->check(CLI::IsMember({2, 3}))
          ->capture_default_str();
  command->add_option("--codec", options->codec, "Compression of bricks")
      ->check(CLI::IsMember({"zstd", "lz4", "none"}))
      ->capture_default_str();
  command
      ->add_option("--type", options->type,
                   "Type of the voxels (default: u8 or u16 for samples of 8 or 16 bits, else f32)")
      ->check(CLI::IsMember({"u8", "u16", "f32"}));
  command->add_option("--memory", options->memory, "Memory that the build may take")->capture_default_str();
  command->add_option("--threads", options->threads, "Number of threads; 0: all cores")
      ->check(CLI::Range(0, 1024));
  options->labels_option = command->add_flag("--labels,!--no-labels", options->labels,
                                             "The numbers name classes, or they are values (default: as the "
                                             "file says). Classes are never averaged or blended: coarse "
                                             "levels take the most frequent one");
  command->add_flag("--force", options->force, "Replace the store if it exists");
  options->volume.add_to(*command);
  options->mesh.add_to(*command);
  return [options] { return build(*options); };
}

}  // namespace gvx::app
