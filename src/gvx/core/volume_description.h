/// \file
/// VolumeDescription: what is known of a volume whatever holds it: of what kind its voxels are, what their
/// numbers mean, and which way its world is turned. A file's description (store/format.h) and a tree's
/// (tree/tree_description.h) add the grid and the place.
#pragma once

#include <cstdint>
#include <vector>

#include "gvx/core/up_axis.h"
#include "gvx/core/voxel.h"

namespace gvx {

struct VolumeDescription {
  VoxelFormat format;
  bool no_data = false;          ///< f32 voxels may be NaN: no data, which is in no range or histogram
  bool anatomical = false;       ///< world is millimetres: x right, y anterior, z superior
  UpAxis up = UpAxis::z;         ///< the axis of the world that points up
  double scale = 1, offset = 0;  ///< physical value = scale * stored value + offset
  ChannelRanges ranges;          ///< of all stored values
  /// For each channel: counts of the finest voxels in equal bins over its range. May be empty.
  std::vector<std::vector<std::uint64_t>> histograms;
};

}  // namespace gvx
