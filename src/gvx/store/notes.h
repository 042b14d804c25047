/// \file
/// The optional section "notes" of a store: what its source says for people, the unit of lengths and the
/// names and colours of channels. Nothing that is needed to read voxels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/vec.h"

namespace gvx::store {

class StoreReader;
class StoreWriter;

inline constexpr const char* kNotesSection = "notes";

struct ChannelNotes {
  std::string name;            ///< Empty: none.
  std::optional<Vec3f> color;  ///< Red, green and blue from 0 to 1.
};

struct VolumeNotes {
  std::string unit;                    ///< Of lengths in world space; empty: not known.
  std::vector<ChannelNotes> channels;  ///< One a channel, or none.

  bool empty() const { return unit.empty() && channels.empty(); }
};

/// Adds the section, before finish(); nothing where there are no notes.
Status write_notes(StoreWriter& writer, const VolumeNotes& notes);

/// Empty where the store has none. An error where the section is broken or has not as many channels as the
/// store.
Result<VolumeNotes> read_notes(const StoreReader& reader);

}  // namespace gvx::store
