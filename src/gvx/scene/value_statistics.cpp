#include "gvx/scene/value_statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace gvx::scene {
namespace {

/// The voxels of bins, from one on, up to before another.
double count(const ValueStatistics& s, std::size_t first, std::size_t end) {
  const auto at = [&](std::size_t bin) { return s.histogram.begin() + static_cast<std::ptrdiff_t>(bin); };
  return static_cast<double>(std::accumulate(at(first), at(end), std::uint64_t(0)));
}

/// The bin that holds a value.
std::size_t bin_of(const ValueStatistics& s, double value) {
  const auto bins = static_cast<double>(s.histogram.size());
  return static_cast<std::size_t>(std::clamp((value - s.minimum) / s.width() * bins, 0.0, bins));
}

/// Where a place in the histogram, in bins, lies among the values.
double value_at(const ValueStatistics& s, double bin) {
  const double share = bin / static_cast<double>(s.histogram.size());
  // Neither side overflows where the values span all that a double holds.
  return (1 - share) * s.minimum + share * s.maximum;
}

/// The place, in bins from `first` on, below which `share` of the voxels of those before `end` lie.
double place_of(const ValueStatistics& s, std::size_t first, std::size_t end, double share) {
  const double wanted = share * count(s, first, end);
  double below = 0;
  for (std::size_t i = first; i < end; ++i) {
    const auto here = static_cast<double>(s.histogram[i]);
    if (here > 0 && below + here >= wanted) return static_cast<double>(i) + (wanted - below) / here;
    below += here;
  }
  return static_cast<double>(end);
}

struct Split {
  double place;       ///< in bins
  double separation;  ///< 0 to 1
};

/// Otsu's, of the bins before `end`.
Split best_split(const ValueStatistics& s, std::size_t first, std::size_t end) {
  double all = 0, moment = 0, square = 0;
  for (std::size_t i = first; i < end; ++i) {
    const auto voxels = static_cast<double>(s.histogram[i]), place = static_cast<double>(i);
    all += voxels;
    moment += voxels * place;
    square += voxels * place * place;
  }
  double best = -1, below = 0, below_moment = 0;
  std::size_t from = (first + end) / 2, to = from;  // equally good bins: an empty valley
  for (std::size_t i = first; i + 1 < end; ++i) {
    below += static_cast<double>(s.histogram[i]);
    below_moment += static_cast<double>(i) * static_cast<double>(s.histogram[i]);
    if (below <= 0 || below >= all) continue;
    const double apart = below_moment / below - (moment - below_moment) / (all - below);
    const double between = below * (all - below) * apart * apart;
    if (between > best * (1 + 1e-12)) {
      best = between;
      from = i;
    }
    if (between >= best * (1 - 1e-12)) to = i;
  }
  const double variance = all > 0 ? square / all - (moment / all) * (moment / all) : 0;
  const double separation = best > 0 && variance > 0 ? best / (all * all * variance) : 0;
  return {0.5 * static_cast<double>(from + to) + 1, std::min(separation, 1.0)};
}

/// The middle of the fullest of about 64 equal parts of the bins.
double fullest_place(const ValueStatistics& s, std::size_t first, std::size_t end, std::size_t part) {
  double most = -1;
  std::size_t fullest = first;
  for (std::size_t i = first; i < end; i += part) {
    const double voxels = count(s, i, std::min(i + part, end));
    if (voxels > most) {
      most = voxels;
      fullest = i;
    }
  }
  return place_of(s, fullest, std::min(fullest + part, end), 0.5);
}

}  // namespace

double ValueStatistics::percentile(double share) const {
  const double all = count(*this, 0, histogram.size());
  if (!(all > 0)) return (1 - share) * minimum + share * maximum;
  return value_at(*this, place_of(*this, 0, histogram.size(), share));
}

double ValueStatistics::width() const {
  const double width = maximum - minimum;
  if (width > 0) return width;
  return minimum != 0 ? 1e-3 * std::abs(minimum) : 1;
}

ValueStatistics physical_statistics(ValueRange stored, std::vector<std::uint64_t> histogram, double scale,
                                    double offset) {
  ValueStatistics statistics{scale * stored.minimum + offset, scale * stored.maximum + offset,
                             std::move(histogram)};
  if (statistics.minimum > statistics.maximum) {
    std::swap(statistics.minimum, statistics.maximum);
    std::reverse(statistics.histogram.begin(), statistics.histogram.end());
  }
  return statistics;
}

HistogramShape histogram_shape(const ValueStatistics& s) {
  constexpr double kOutliers = 1e-3;  // at either end
  constexpr std::size_t kParts = 64;
  constexpr double kQuartile = 0.6745;  // of a normal distribution, in standard deviations
  const std::size_t bins = s.histogram.size();
  const auto first = static_cast<std::size_t>(place_of(s, 0, bins, kOutliers));
  const double top = place_of(s, 0, bins, 1 - kOutliers);
  const std::size_t end =
      std::clamp(static_cast<std::size_t>(std::ceil(top)), std::min(first + 1, bins), bins);
  const Split split = best_split(s, std::min(first, end), end);
  const auto middle = std::clamp(static_cast<std::size_t>(split.place), std::min(first, end), end);
  const double background =
      fullest_place(s, std::min(first, middle), middle, std::max<std::size_t>((end - first) / kParts, 1));
  const double median = place_of(s, first, middle, 0.5);
  // Above the median there is more than noise: voxels that the object has a part of.
  const double deviation = (median - place_of(s, first, middle, 0.25)) / kQuartile;
  HistogramShape shape;
  shape.threshold = value_at(s, split.place);
  shape.separation = split.separation;
  shape.background = value_at(s, background);
  shape.noise_top = value_at(s, median + 4 * deviation);
  shape.top = value_at(s, top);
  return shape;
}

double share_above(const ValueStatistics& s, double floor) {
  constexpr double kLeast = 1e-3;
  const std::size_t bins = s.histogram.size();
  const double all = count(s, 0, bins);
  if (!(all > 0)) return 1;
  return std::max(count(s, bin_of(s, floor), bins) / all, kLeast);
}

double percentile_above(const ValueStatistics& s, double floor, double share) {
  const double value = value_at(s, place_of(s, bin_of(s, floor), s.histogram.size(), share));
  return std::max(value, floor);
}

}  // namespace gvx::scene
