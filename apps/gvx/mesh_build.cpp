#include "mesh_build.h"

#include <filesystem>
#include <iterator>
#include <optional>
#include <string_view>
#include <vector>

#include "messages.h"
#include "progress.h"

namespace gvx::app {

void MeshFlags::add_to(CLI::App& command) {
  const char* group = "Mesh input";
  command.add_option("--resolution", resolution_, "Voxels along the longest side of a mesh (512)")
      ->check(CLI::Range(1, 1 << 20))
      ->group(group);
  command
      .add_option("--fill", fill_,
                  "solid: the inside of the mesh is opaque; shell: only its surface, 1.5 voxels thick "
                  "(default: solid if the mesh is closed)")
      ->check(CLI::IsMember({"solid", "shell"}))
      ->group(group);
  command
      .add_option("--up", up_,
                  "The axis of the mesh that points up (default: y for glTF, OBJ and PLY, z for STL)")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kUpAxisNames), std::end(kUpAxisNames))))
      ->group(group);
}

Result<mesh::MeshStoreOptions> MeshFlags::parse() const {
  mesh::MeshStoreOptions options;
  if (resolution_) options.resolution = *resolution_;
  return options;
}

MeshFlags::Fill MeshFlags::fill() const {
  return !fill_ ? Fill::automatic : *fill_ == "solid" ? Fill::solid : Fill::shell;
}

std::optional<UpAxis> MeshFlags::up() const {
  if (!up_) return std::nullopt;
  return *up_ == kUpAxisNames[static_cast<std::size_t>(UpAxis::y)] ? UpAxis::y : UpAxis::z;
}

std::string up_note(const std::string& path, const io::MeshUp& up) {
  if (!up.guessed) return {};
  return path + ": " + kUpAxisNames[static_cast<std::size_t>(up.axis)] + " is up, " + up.why +
         " (--up overrides it)";
}

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

Result<BuiltMesh> build_mesh(const exec::Device& cpu, const std::string& path, const std::string& output,
                             mesh::MeshStoreOptions options, MeshFlags::Fill fill, std::optional<UpAxis> up,
                             const std::string& title, const std::string& scratch_folder, bool quiet) {
  const std::string beside = std::filesystem::path(output).parent_path().string();
  const std::string folder = !scratch_folder.empty() ? scratch_folder : beside.empty() ? "." : beside;
  std::optional<Progress> progress;
  std::string shown;
  const mesh::MeshBuildProgress show = [&](const char* what, std::uint64_t done, std::uint64_t all) {
    if (shown != what) {
      const bool voxels = std::string_view(what) == "building";
      progress.emplace(title + (shown = what), voxels ? Progress::Unit::voxels : Progress::Unit::none, quiet);
    }
    progress->show(done, all);
  };
  GVX_ASSIGN(const auto mesh,
             mesh::spool_mesh(path, folder, options.memory_bytes,
                              [&](std::uint64_t done, std::uint64_t all) { show("reading", done, all); }));
  const mesh::MeshSummary& summary = mesh->summary();
  options.solid = fill != MeshFlags::Fill::shell && summary.closed();
  if (fill == MeshFlags::Fill::solid && !options.solid) {
    return Error{path + ": the mesh is not closed, so it has no inside (--fill shell)"};
  }
  const io::MeshUp likely = io::mesh_up(path, summary.bounds);
  options.up = up.value_or(likely.axis);
  options.source = std::filesystem::path(path).filename().string();
  const std::string notes = mesh_notes(summary, options.solid);
  if (!notes.empty()) {
    progress.reset();
    warn(path + ": " + notes);
  }
  GVX_ASSIGN(const auto report, mesh::build_mesh_store(cpu, *mesh, output, options, show));
  return BuiltMesh{report, up ? "" : up_note(path, likely)};
}

}  // namespace gvx::app
