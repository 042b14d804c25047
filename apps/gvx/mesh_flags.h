/// \file
/// MeshFlags: the flags that say what voxels become of a mesh.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "gvx/io/mesh.h"
#include "gvx/open/mesh_store.h"

namespace gvx::app {

/// --as, --resolution, --fill, --up.
class MeshFlags {
 public:
  void add_to(CLI::App& command);
  open::MeshBuild parse() const;
  /// Was any of them given?
  bool given() const { return as_ || resolution_ || fill_ || up_; }
  /// Does the mesh become a surface, or voxels? An error where flags of both were given.
  Result<bool> as_surface() const;

 private:
  std::optional<std::int64_t> resolution_;
  std::optional<std::string> as_, fill_, up_;
};

/// "bunny.obj: y is up, as in most OBJ files (--up overrides it)", if that is a guess; otherwise empty.
std::string up_note(const std::string& path, const io::MeshUp& up);

}  // namespace gvx::app
