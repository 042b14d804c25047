/// \file
/// Siemens mosaics: one image whose tiles are the slices of a volume. How many there are, and where they lie,
/// is in a private header (CSA), whose layout NiBabel documents ("Siemens format DICOM with CSA header").
#pragma once

#include <cstdint>
#include <optional>

#include "gvx/core/vec.h"
#include "gvx/io/dicom_dataset.h"

namespace gvx::io {

struct DicomMosaic {
  std::int64_t tiles = 0;
  std::optional<Vec3d> normal;  ///< From tile to tile; may be opposite to row x column.
};

/// Nothing where the file is no mosaic.
std::optional<DicomMosaic> find_mosaic(const DicomDataset& elements);

}  // namespace gvx::io
