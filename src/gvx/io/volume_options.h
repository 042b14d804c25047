/// \file
/// VolumeOptions: what a person says of a volume file beside its name.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gvx/io/raw.h"

namespace gvx::io {

struct VolumeOptions {
  RawOptions raw;                     ///< Of samples without a header; its spacing is for any format.
  std::optional<std::string> series;  ///< Which series of a folder of DICOM files, as gvx info lists them.
  std::optional<std::int64_t> time;   ///< Which frame of a volume that changes with time, from 0.
  std::optional<bool> labels;         ///< Do the numbers name classes? None: as the file says.
  bool even_slices = false;           ///< Resample slices that are uneven, tilted or missing.

  VolumeOptions(const RawOptions& samples = {}) : raw(samples) {}
};

}  // namespace gvx::io
