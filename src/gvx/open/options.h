/// \file
/// OpenOptions: on which devices a scene is opened, and who hears of it. FieldNaming: what messages call the
/// fields of a scene.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/exec/device.h"

namespace gvx::open {

/// Takes one line that is a warning.
using Warn = std::function<void(const std::string&)>;

/// How far a long piece of work is.
struct Work {
  enum class Unit { bytes, voxels, none };

  const char* what = "building";  ///< one of several pieces in a row: "reading", "sorting", "building"
  Unit unit = Unit::none;         ///< of what is counted
  std::uint64_t done = 0, all = 0;
};
/// Called from one thread.
using ShowWork = std::function<void(const Work&)>;

/// What messages call a field: by its name in scene files; or by that of a flag, where the field was said by
/// one.
class FieldNaming {
 public:
  /// The flag by which a field was said; empty: by none. "functions" is the list as a whole,
  /// "functions[0].window" a field of one of them.
  using FlagOf = std::function<std::string(const std::string& field)>;

  FieldNaming() = default;
  explicit FieldNaming(FlagOf flag_of) : flag_of_(std::move(flag_of)) {}

  /// "--labels", or "labels".
  std::string name(const std::string& field) const;
  /// "--labels " before its value, or "labels: ".
  std::string before_value(const std::string& field) const;
  /// What tells a user to say something: `flags` where there are any, otherwise `fields`.
  std::string advice(const char* flags, const char* fields) const;

 private:
  FlagOf flag_of_;
};

struct OpenOptions {
  exec::Device cpu = exec::Device::cpu();  ///< for what only runs there
  exec::Device render = cpu;               ///< where pictures are made, and what kernels make of them
  Warn warn = [](const std::string&) {};
  /// Of another program's volume or mesh, which becomes a temporary store.
  ShowWork show_work = [](const Work&) {};
  /// Asked with what is known of such a file before that is built, which takes time; its error ends the work.
  std::function<Status(const VoxelFormat&)> before_build = [](const VoxelFormat&) { return Status(); };
  FieldNaming naming = {};
};

}  // namespace gvx::open
