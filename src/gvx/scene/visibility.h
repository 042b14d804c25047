/// \file
/// Mode: what becomes of the values along a ray; and Visibility, which nodes that leaves nothing to see of.
#pragma once

#include <cstdint>

#include "gvx/core/added_noise.h"
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

/// Does it show the greatest or the least of the values along a ray?
GVX_HD constexpr bool seeks_extreme(Mode mode) {
  return mode == Mode::maximum || mode == Mode::minimum;
}

/// Does it show one value of all those along a ray?
GVX_HD constexpr bool projects(Mode mode) {
  return seeks_extreme(mode) || mode == Mode::mean;
}

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
  float noise_reach = 0;   ///< by which rays may find other values than nodes have, at most
  ValueRange noise_fades;  ///< and towards which values less (core/added_noise.h)

  /// Can nothing in a node of these ranges be seen? Conservative: true is certain.
  GVX_HD bool hides(const ChannelRanges& ranges) const {
    if (mode == Mode::isosurface) return !widened(ranges.channel[0]).contains(isovalue);
    if (mode != Mode::composite) return false;
    bool hidden = true;
    for (std::uint32_t c = 0; c < channels; ++c) {
      // Where a node has one value, nothing is added.
      const ValueRange range = ranges.channel[c];
      hidden = hidden && functions[c].transparent(range.minimum < range.maximum ? widened(range) : range);
    }
    return hidden;
  }
  /// And where noise may be added to this value?
  GVX_HD bool hides_noise_at(float value) const {
    const ValueRange range = widened({value, value});
    if (mode == Mode::isosurface) return !range.contains(isovalue);
    return mode == Mode::composite && functions[0].transparent(range);
  }

  /// What rays may find where a volume has these values.
  GVX_HD ValueRange widened(ValueRange range) const {
    if (!(noise_reach > 0)) return range;
    const auto reach = static_cast<float>(noise_reach * AddedNoise::most_share(range, noise_fades));
    return {range.minimum - reach, range.maximum + reach};
  }
};

}  // namespace gvx::scene
