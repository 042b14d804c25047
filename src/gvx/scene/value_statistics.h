/// \file
/// ValueStatistics: the range and histogram of a volume's values, to which presets fit a transfer function.
/// HistogramShape: the background and the object in a histogram.
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
  bool anatomical = false;                    ///< a scan of a patient
  std::uint32_t channel = 0, channels = 1;
  /// The side of a cube as large as the volume's box, in world units; 0 if it is not known.
  double size_world = 0;
  /// In which the source shows the channel: red, green, blue from 0 to 1.
  std::optional<Vec3d> color = {};

  /// The physical value below which this share (0 to 1) of the voxels lie; linear within a bin. Without a
  /// histogram: the value at that share of the way from minimum to maximum.
  double percentile(double share) const;
  /// maximum - minimum. If there is only one value: a small number relative to it.
  double width() const;
};

/// The statistics in physical values, from those of stored values.
ValueStatistics physical_statistics(ValueRange stored, std::vector<std::uint64_t> histogram, double scale,
                                    double offset);

/// Physical values. All except `separation` ignore the outermost thousandths of the voxels.
struct HistogramShape {
  /// Divides the histogram into the two most compact groups (N. Otsu, "A Threshold Selection Method from
  /// Gray-Level Histograms", 1979). The middle of a valley, if it is empty.
  double threshold = 0;
  /// The share of the variance that lies between these groups, 0 to 1: 1 for two sharp peaks.
  double separation = 0;
  double background = 0;  ///< the most frequent value below the threshold
  double noise_top = 0;   ///< background noise reaches up to here: four standard deviations above its median
  double top = 0;         ///< all voxels but a thousandth lie below
};

/// The histogram must not be empty.
HistogramShape histogram_shape(const ValueStatistics& statistics);

/// The share of the voxels above `floor`, at least a thousandth; exact to a bin.
double share_above(const ValueStatistics& statistics, double floor);

/// The value below which lies this share of the voxels above `floor`.
double percentile_above(const ValueStatistics& statistics, double floor, double share);

}  // namespace gvx::scene
