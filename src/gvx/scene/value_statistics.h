/// \file
/// ValueStatistics: what is known of a volume's values, which a transfer function fits itself to; and
/// HistogramShape, what the histogram says of background and object.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "gvx/core/vec.h"
#include "gvx/core/voxel.h"

namespace gvx::scene {

struct ValueStatistics {
  double minimum = 0, maximum = 0;            ///< physical
  std::vector<std::uint64_t> histogram = {};  ///< equal bins from minimum to maximum; may be empty
  bool anatomical = false;                    ///< of a patient
  std::uint32_t channel = 0, channels = 1;
  /// The side of a cube as large as the volume's box, in world units; 0 where it is not known.
  double size_world = 0;
  /// In which the source shows the channel: red, green, blue from 0 to 1.
  std::optional<Vec3d> color = {};

  /// The physical value below which `share` of the voxels lie, 0 to 1, linear within a bin; without a
  /// histogram, that share of the way from minimum to maximum.
  double percentile(double share) const;
  /// Of the values; where there is but one, something that is small beside it.
  double width() const;
};

/// Statistics of stored values, in physical ones.
ValueStatistics physical_statistics(ValueRange stored, std::vector<std::uint64_t> histogram, double scale,
                                    double offset);

/// The values are physical. All but `separation` are robust: the outermost thousandths of the voxels say
/// nothing.
struct HistogramShape {
  /// Parts the histogram into the two most compact groups (N. Otsu, "A Threshold Selection Method from
  /// Gray-Level Histograms", 1979); the middle of an empty valley.
  double threshold = 0;
  /// The share of the variance that lies between these groups, 0 to 1: 1 for two sharp peaks.
  double separation = 0;
  double background = 0;  ///< the most frequent value below the threshold
  double noise_top = 0;   ///< up to here background may be noise: four standard deviations above its median
  double top = 0;         ///< all but a thousandth of the voxels lie below
};

/// Of a histogram that is not empty.
HistogramShape histogram_shape(const ValueStatistics& statistics);

/// The share of the voxels that lie above `floor`, at least a thousandth, to a bin.
double share_above(const ValueStatistics& statistics, double floor);

/// The value below which `share` of those voxels lie that are above `floor`.
double percentile_above(const ValueStatistics& statistics, double floor, double share);

}  // namespace gvx::scene
