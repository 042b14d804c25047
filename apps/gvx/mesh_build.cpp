#include "mesh_build.h"

#include <cstdio>
#include <filesystem>

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

Result<produce::MeshStoreReport> build_mesh(
    const exec::Device& cpu, const std::string& path, const std::string& output,
    produce::MeshStoreOptions options, MeshFlags::Fill fill,
    const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  io::MeshReport report;
  GVX_ASSIGN(io::TriangleMesh mesh, io::read_mesh(path, &report));
  const bool closed = fill != MeshFlags::Fill::shell && produce::is_closed(mesh);
  if (fill == MeshFlags::Fill::solid && !closed) {
    return Error{path + ": the mesh is not closed, so it has no inside (--fill shell)"};
  }
  options.solid = closed;
  options.source = std::filesystem::path(path).filename().string();
  if (report.dropped > 0) {
    std::fprintf(stderr, "gvx: %s: %llu triangles cover nothing; they are left out\n", path.c_str(),
                 static_cast<unsigned long long>(report.dropped));
  }
  return produce::build_mesh_store(cpu, std::move(mesh), output, options, progress);
}

}  // namespace gvx::app
