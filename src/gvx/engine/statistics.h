/// \file
/// Statistics: what a frame cost and how far it came.
#pragma once

#include <cstdint>

namespace gvx::engine {

struct Statistics {
  double frame_milliseconds = 0;
  std::uint64_t passes = 0;           ///< of this frame
  std::uint64_t requests = 0;         ///< nodes that rays marked in this frame, summed over its passes
  std::uint64_t bricks_produced = 0;  ///< made in this frame
  std::uint64_t bricks_evicted = 0;   ///< of this frame
  std::uint64_t bricks_resident = 0;
  std::uint64_t nodes_resident = 0;
  std::uint64_t bytes_read = 0;         ///< by the producer since it was opened
  std::uint64_t samples = 0;            ///< of the exact rays of this view so far
  std::uint64_t peak_memory_bytes = 0;  ///< of the process
  bool converged = false;               ///< the picture is the exact one
  double resident_share = 0;            ///< of what the preview's rays wanted; 1 where the picture is exact
  std::uint32_t worst_lack = 0;         ///< the most levels by which the preview is coarser than wanted
  double level_bias = 0;                ///< by how many levels the preview wants less than the exact picture
};

/// The largest resident set of this process so far.
std::uint64_t peak_memory_bytes();

}  // namespace gvx::engine
