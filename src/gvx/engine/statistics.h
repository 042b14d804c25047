/// \file
/// Statistics: what a frame cost and how far it came.
#pragma once

#include <array>
#include <cstdint>
#include <utility>

namespace gvx::engine {

/// Where time went, in milliseconds. Producers' threads work beside the caller's: theirs are sums over them,
/// the others wall time since the engine was made.
struct StageTimes {
  double reading = 0;     ///< of files, since the producer was opened, its header too
  double decoding = 0;    ///< checksums and decompression, since then
  double producing = 0;   ///< all that producers' threads do: the two above, and the analysis of bricks
  double marching = 0;    ///< rays, those of previews too
  double committing = 0;  ///< collecting what rays asked for, and putting what was made into the pools
  double waiting = 0;     ///< for producers

  std::array<std::pair<const char*, double>, 6> named() const {
    return {{{"reading", reading},
             {"decoding", decoding},
             {"producing", producing},
             {"marching", marching},
             {"committing", committing},
             {"waiting", waiting}}};
  }
};

struct Statistics {
  double frame_milliseconds = 0;
  std::uint64_t passes = 0;           ///< of this frame
  std::uint64_t requests = 0;         ///< nodes that rays marked in this frame, summed over its passes
  std::uint64_t bricks_produced = 0;  ///< made in this frame
  std::uint64_t bricks_evicted = 0;   ///< of this frame
  std::uint64_t bricks_resident = 0;
  std::uint64_t nodes_resident = 0;
  std::uint64_t bricks_beyond_bounds =
      0;                         ///< since the engine was made: they hold what their nodes did not promise
  std::uint64_t bytes_read = 0;  ///< by the producer since it was opened
  std::uint64_t samples = 0;     ///< of the exact rays of this view so far
  std::uint64_t peak_memory_bytes = 0;  ///< of the process
  bool converged = false;               ///< the picture is the exact one
  double resident_share = 0;            ///< of what the preview's rays wanted; 1 where the picture is exact
  std::uint32_t worst_lack = 0;         ///< the most levels by which the preview is coarser than wanted
  double level_bias = 0;                ///< by how many levels the preview wants less than the exact picture
  StageTimes stages;
};

/// The largest resident set of this process so far.
std::uint64_t peak_memory_bytes();

}  // namespace gvx::engine
