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

/// --resolution, --fill, --up.
class MeshFlags {
 public:
  void add_to(CLI::App& command);
  open::MeshBuild parse() const;
  /// Was any of them given?
  bool given() const { return resolution_ || fill_ || up_; }

 private:
  std::optional<std::int64_t> resolution_;
  std::optional<std::string> fill_, up_;
};

/// "bunny.obj: y is up, as in most OBJ files (--up overrides it)", if that is a guess; otherwise empty.
std::string up_note(const std::string& path, const io::MeshUp& up);

}  // namespace gvx::app
