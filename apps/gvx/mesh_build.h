/// \file
/// From a mesh file to a store: the flags that say how, and the work.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/up_axis.h"
#include "gvx/exec/device.h"
#include "gvx/io/mesh.h"
#include "gvx/mesh/mesh_voxels.h"

namespace gvx::app {

/// Says what voxels become of a mesh: --resolution, --fill, --up.
class MeshFlags {
 public:
  enum class Fill { automatic, solid, shell };

  void add_to(CLI::App& command);
  Result<mesh::MeshStoreOptions> parse() const;
  Fill fill() const;
  /// The axis that points up, where that was said.
  std::optional<UpAxis> up() const;
  /// Was any of them given?
  bool given() const { return resolution_ || fill_ || up_; }

 private:
  std::optional<std::int64_t> resolution_;
  std::optional<std::string> fill_, up_;
};

/// What a user should know of how a mesh was read, without a line end; empty where there is nothing to say.
/// `solid`: was it filled?
std::string mesh_notes(const mesh::MeshSummary& summary, bool solid);

/// "bunny.obj: y is up, as in most OBJ files (--up overrides it)", if that is a guess; otherwise empty.
std::string up_note(const std::string& path, const io::MeshUp& up);

struct BuiltMesh {
  mesh::MeshStoreReport store;
  std::string note;  ///< up_note(), unless the axis was said
};

/// Reads the mesh and writes the store; `fill` says what `options.solid` becomes, and `up`, or a guess, what
/// `options.up` becomes. Where standard error is a
/// terminal it says how far it is, behind `title`. Scratch files stand in `scratch_folder`, or beside the
/// store.
Result<BuiltMesh> build_mesh(const exec::Device& cpu, const std::string& path, const std::string& output,
                             mesh::MeshStoreOptions options, MeshFlags::Fill fill, std::optional<UpAxis> up,
                             const std::string& title = "", const std::string& scratch_folder = "",
                             bool quiet = false);

}  // namespace gvx::app
