/// \file
/// What a store's header says, of every version that this program reads.
#pragma once

#include <cstdint>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/format.h"
#include "gvx/store/sections.h"
#include "gvx/store/store_file.h"

namespace gvx::store {

/// The header and the table of sections, whatever the version.
struct StoreHeader {
  std::uint32_t version = kVersion;
  VolumeInfo info;  ///< without what the metadata say
  std::uint32_t record_bytes = 0;
  std::vector<Section> sections;
};

/// Reads the header and the table of sections; of version 2 the sections are those that its header names.
/// An error where the file is no whole store of a version that this program reads.
Result<StoreHeader> read_header(const StoreFile& file);

/// A header of kVersion, in which sections, size and checksum are yet to be set.
FileHeader header_of(const VolumeInfo& info, std::uint32_t record_bytes);

}  // namespace gvx::store
