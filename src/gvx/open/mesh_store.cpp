#include "gvx/open/mesh_store.h"

#include <filesystem>
#include <vector>

#include "gvx/mesh/mesh_spool.h"

namespace gvx::open {

std::string mesh_notes(const mesh::MeshSummary& summary, bool solid) {
  std::vector<std::string> notes;
  const auto counted = [](std::uint64_t count, const char* one, const char* several) {
    return std::to_string(count) + (count == 1 ? one : several);
  };
  if (summary.dropped > 0) {
    notes.push_back(counted(summary.dropped, " triangle covers", " triangles cover") + " nothing; left out");
  }
  if (summary.doubled > 0) {
    notes.push_back(counted(summary.doubled, " triangle is", " triangles are") +
                    " there twice; counted once");
  }
  if (solid && summary.inside == mesh::InsideRule::parity) {
    notes.emplace_back(
        "faces are not wound alike: filled by the even-odd rule, so what two parts share stays empty");
  }
  if (!summary.unused.empty()) {
    std::string list;
    for (const std::string& what : summary.unused) list += (list.empty() ? "" : ", ") + what;
    notes.push_back("not used: " + list);
  }
  std::string text;
  for (const std::string& note : notes) text += (text.empty() ? "" : "; ") + note;
  return text;
}

namespace {

std::string scratch_folder(const MeshBuild& build, const std::string& output) {
  const std::string beside = std::filesystem::path(output).parent_path().string();
  return !build.scratch_folder.empty() ? build.scratch_folder : beside.empty() ? "." : beside;
}

}  // namespace

Result<BuiltSurface> build_mesh_surface(const std::string& path, const std::string& output,
                                        const MeshBuild& build, const OpenOptions& options) {
  constexpr std::uint64_t kLeastMemory = 1 << 20;
  if (build.store.memory_bytes < kLeastMemory) {
    return Error{path + ": a surface needs " + store::mebibytes(kLeastMemory) + " of memory; " +
                 std::to_string(build.store.memory_bytes) + " bytes are allowed" +
                 options.naming.advice(" (--memory)", "")};
  }
  const mesh::SurfaceProgress show = [&](const char* what, std::uint64_t done, std::uint64_t all) {
    options.show_work({what, Work::Unit::none, done, all});
  };
  GVX_ASSIGN(const auto mesh,
             mesh::spool_mesh(path, scratch_folder(build, output), build.store.memory_bytes,
                              [&](std::uint64_t done, std::uint64_t all) { show("reading", done, all); }));
  const mesh::MeshSummary& summary = mesh->summary();
  const io::MeshUp likely = io::mesh_up(path, summary.bounds);
  mesh::SurfaceStoreOptions store;
  store.up = build.up.value_or(likely.axis);
  store.codec = build.store.codec;
  store.memory_bytes = build.store.memory_bytes;
  store.source = std::filesystem::path(path).filename().string();
  const std::string notes = mesh_notes(summary, false);
  if (!notes.empty()) options.warn(path + ": " + notes);
  GVX_ASSIGN(const auto report, mesh::build_surface_store(*mesh, output, store, show));
  return BuiltSurface{report, likely, summary.triangles};
}

Result<BuiltMesh> build_mesh(const std::string& path, const std::string& output, MeshBuild build,
                             const OpenOptions& options) {
  const std::string folder = scratch_folder(build, output);
  const mesh::MeshBuildProgress show = [&](const char* what, std::uint64_t done, std::uint64_t all) {
    const bool voxels = std::string_view(what) == "building";
    options.show_work({what, voxels ? Work::Unit::voxels : Work::Unit::none, done, all});
  };
  GVX_ASSIGN(const auto mesh,
             mesh::spool_mesh(path, folder, build.store.memory_bytes,
                              [&](std::uint64_t done, std::uint64_t all) { show("reading", done, all); }));
  const mesh::MeshSummary& summary = mesh->summary();
  build.store.solid = build.fill != Fill::shell && summary.closed();
  if (build.fill == Fill::solid && !build.store.solid) {
    return Error{path + ": the mesh is not closed, so it has no inside (" +
                 options.naming.advice("--fill shell", "fill: shell") + ")"};
  }
  const io::MeshUp likely = io::mesh_up(path, summary.bounds);
  build.store.up = build.up.value_or(likely.axis);
  build.store.source = std::filesystem::path(path).filename().string();
  const std::string notes = mesh_notes(summary, build.store.solid);
  if (!notes.empty()) options.warn(path + ": " + notes);
  GVX_ASSIGN(const auto report, mesh::build_mesh_store(options.cpu, *mesh, output, build.store, show));
  return BuiltMesh{report, likely};
}

}  // namespace gvx::open
