/// \file
/// What values a volume has: range, percentiles, a histogram, and which values where they are few. Of a
/// volume file by reading its samples once in bounded memory; of a store from the histogram that it keeps.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/io/volume_reader.h"

namespace gvx::io {

/// The shares of values, in per cent, whose percentiles are told.
inline constexpr std::array<double, 5> kPercents = {0.1, 1, 50, 99, 99.9};

/// The values of one channel, all as physical values.
struct ValueSummary {
  std::uint64_t numbers = 0;     ///< values that are finite
  std::uint64_t not_finite = 0;  ///< NaN or infinite: no data
  double minimum = 0, maximum = 0;
  /// Of kPercents: so many per cent of the numbers are at most this. Exact for samples of 8 and 16 bits; of
  /// others, to a 256th of the value or of the range, whichever is less.
  std::array<double, kPercents.size()> percentiles = {};
  /// Equal bins from minimum to maximum, the last with the maximum.
  std::vector<std::uint64_t> histogram = {};
  /// All values, ascending, where there are at most kMostDistinct.
  std::optional<std::vector<double>> distinct = {};

  static constexpr std::size_t kBins = 256;
  static constexpr std::size_t kMostDistinct = 256;
};

/// Reads all slices of a volume, which stands at its first; a summary for each of its components. `progress`
/// (may be empty) is called with bytes of samples from this thread.
Result<std::vector<ValueSummary>> survey_values(
    SliceReader& reader, const std::function<void(std::uint64_t done, std::uint64_t all)>& progress);

/// Of stored values in equal bins over their range, of `voxels` voxels in all, with physical = scale * stored
/// + offset. `whole`: the values are whole numbers, so that bins that are no wider than 1 tell each value.
ValueSummary summary_of_bins(ValueRange stored, const std::vector<std::uint64_t>& bins, std::uint64_t voxels,
                             bool whole, double scale, double offset);

}  // namespace gvx::io
