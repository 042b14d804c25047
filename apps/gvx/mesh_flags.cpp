#include "mesh_flags.h"

#include <iterator>
#include <vector>

namespace gvx::app {

void MeshFlags::add_to(CLI::App& command) {
  const char* group = "Mesh input";
  command
      .add_option("--as", as_,
                  "surface: the mesh itself, at all resolutions; voxels: a volume that it is in (default: "
                  "surface, unless --resolution or --fill is given)")
      ->check(CLI::IsMember({"surface", "voxels"}))
      ->group(group);
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

Result<bool> MeshFlags::as_surface() const {
  const bool of_voxels = resolution_ || fill_;
  if (as_ == "surface" && of_voxels) return Error{"--as surface: --resolution and --fill are for voxels"};
  return as_ ? *as_ == "surface" : !of_voxels;
}

open::MeshBuild MeshFlags::parse() const {
  open::MeshBuild build;
  if (resolution_) build.store.resolution = *resolution_;
  if (fill_) build.fill = *fill_ == "solid" ? open::Fill::solid : open::Fill::shell;
  if (up_) build.up = *up_ == kUpAxisNames[static_cast<std::size_t>(UpAxis::y)] ? UpAxis::y : UpAxis::z;
  return build;
}

std::string up_note(const std::string& path, const io::MeshUp& up) {
  if (!up.guessed) return {};
  return path + ": " + kUpAxisNames[static_cast<std::size_t>(up.axis)] + " is up, " + up.why +
         " (--up overrides it)";
}

}  // namespace gvx::app
