/// \file
/// Mode: what becomes of the values along a ray; and Visibility, which nodes that leaves nothing to see of.
#pragma once

#include <cstdint>

#include "gvx/core/voxel.h"
#include "gvx/scene/transfer_function.h"

namespace gvx::scene {

enum class Mode : std::uint32_t {
  composite,   ///< emission and absorption, front to back
  maximum,     ///< the greatest value, through the transfer function
  minimum,     ///< the least value
  mean,        ///< the mean value along the ray within the volume
  isosurface,  ///< the first surface where the value is the isovalue
};

/// How values along a ray become matter, where it is composited.
enum class Classification : std::uint32_t {
  preintegrated,  ///< a step is the mean matter of all values that it goes through: thin layers are not
                  ///< missed
  post,           ///< a step is the matter at its centre's value: faster, as most renderers do
};

/// What the tree is pruned by; the same for all rays of a frame.
struct Visibility {
  Mode mode = Mode::composite;
  std::uint32_t channels = 1;
  float isovalue = 0;  ///< stored
  TransferView functions[kMaxChannels];

  /// Can nothing in a node of these ranges be seen? Conservative: true is certain.
  GVX_HD bool hides(const ChannelRanges& ranges) const {
    if (mode == Mode::isosurface) return !ranges.channel[0].contains(isovalue);
    if (mode != Mode::composite) return false;
    bool hidden = true;
    for (std::uint32_t c = 0; c < channels; ++c) {
      hidden = hidden && functions[c].transparent(ranges.channel[c]);
    }
    return hidden;
  }
};

}  // namespace gvx::scene
