#include "mesh_build.h"

#include <cstdio>
#include <filesystem>
#include <optional>

#include "progress.h"

namespace gvx::app {

void MeshFlags::add_to(CLI::App& command) {
  const char* group = "Mesh input";
  command.add_option("--resolution", resolution_, "Voxels along the longest side of a mesh (512)")
      ->check(CLI::Range(1, 1 << 20))
      ->group(group);
  command
      .add_option("--fill", fill_,
                  "solid: what a mesh encloses is opaque; shell: only its surface, one and a half voxels "
                  "thick; without it "
                  "solid where the mesh is closed")
      ->check(CLI::IsMember({"solid", "shell"}))
      ->group(group);
}

Result<produce::MeshStoreOptions> MeshFlags::parse() const {
  produce::MeshStoreOptions options;
  if (resolution_) options.resolution = *resolution_;
  return options;
}

MeshFlags::Fill MeshFlags::fill() const {
  return !fill_ ? Fill::automatic : *fill_ == "solid" ? Fill::solid : Fill::shell;
}

Result<produce::MeshStoreReport> build_mesh(const exec::Device& cpu, const std::string& path,
                                            const std::string& output, produce::MeshStoreOptions options,
                                            MeshFlags::Fill fill, const std::string& title,
                                            const std::string& scratch_folder) {
  const std::string beside = std::filesystem::path(output).parent_path().string();
  const std::string folder = !scratch_folder.empty() ? scratch_folder : beside.empty() ? "." : beside;
  std::optional<Progress> progress;
  std::string shown;
  const produce::MeshBuildProgress show = [&](const char* what, std::uint64_t done, std::uint64_t all) {
    if (shown != what) progress.emplace(title + (shown = what), "items");
    progress->show(done, all);
  };
  GVX_ASSIGN(const auto mesh,
             produce::spool_mesh(path, folder, options.memory_bytes, produce::MeshSpool::Keep::triangles,
                                 [&](std::uint64_t done, std::uint64_t all) { show("reading", done, all); }));
  const produce::MeshSummary& summary = mesh->summary();
  options.solid = fill != MeshFlags::Fill::shell && summary.closed;
  if (fill == MeshFlags::Fill::solid && !options.solid) {
    return Error{path + ": the mesh is not closed, so it has no inside (--fill shell)"};
  }
  options.source = std::filesystem::path(path).filename().string();
  if (summary.dropped > 0) {
    progress.reset();
    std::fprintf(stderr, "gvx: %s: %llu triangles cover nothing; they are left out\n", path.c_str(),
                 static_cast<unsigned long long>(summary.dropped));
  }
  return produce::build_mesh_store(cpu, *mesh, output, options, show);
}

}  // namespace gvx::app
