#include "gvx/io/value_survey.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "gvx/io/sample_conversion.h"

namespace gvx::io {
namespace {

/// So many numbers lie from `first` to `last`.
struct Group {
  double first = 0, last = 0;
  std::uint64_t count = 0;
};

/// The value that this share of the numbers in ascending groups is not above; within a group they are taken
/// to lie evenly.
double percentile(std::span<const Group> groups, std::uint64_t numbers, double percent) {
  // 99.9 % of 1000 are 999, and not a rounding more.
  const double rank = std::max(1.0, percent / 100 * static_cast<double>(numbers) * (1 - 1e-12));
  double below = 0;
  for (const Group& group : groups) {
    const auto count = static_cast<double>(group.count);
    if (below + count >= rank) return std::lerp(group.first, group.last, (rank - below) / count);
    below += count;
  }
  return groups.empty() ? 0 : groups.back().last;
}

std::vector<std::uint64_t> equal_bins(std::span<const Group> groups, double minimum, double maximum) {
  std::vector<std::uint64_t> bins(ValueSummary::kBins);
  const double scale = maximum > minimum ? ValueSummary::kBins / (maximum - minimum) : 0;
  const auto bin_of = [&](double value) {
    return std::clamp((value - minimum) * scale, 0.0, static_cast<double>(ValueSummary::kBins));
  };
  for (const Group& group : groups) {
    // Where a group reaches over several bins each gets its share, and none is lost.
    const double first = bin_of(group.first), last = bin_of(group.last);
    std::uint64_t put = 0;
    for (auto bin = static_cast<std::size_t>(std::min(first, ValueSummary::kBins - 1.0)); put < group.count;
         ++bin) {
      const double share = last > first ? (static_cast<double>(bin + 1) - first) / (last - first) : 1;
      const auto up_to = share < 1 && bin + 1 < bins.size()
                             ? static_cast<std::uint64_t>(share * static_cast<double>(group.count))
                             : group.count;
      bins[bin] += up_to - put;
      put = up_to;
    }
  }
  return bins;
}

/// Of groups in ascending order, none of which is empty.
ValueSummary summarize(std::vector<Group> groups, double scale, double offset) {
  for (Group& group : groups) {
    group.first = scale * group.first + offset;
    group.last = scale * group.last + offset;
    if (scale < 0) std::swap(group.first, group.last);
  }
  if (scale < 0) std::reverse(groups.begin(), groups.end());
  ValueSummary summary;
  for (const Group& group : groups) summary.numbers += group.count;
  if (groups.empty()) return summary;
  summary.minimum = groups.front().first;
  summary.maximum = groups.back().last;
  for (std::size_t i = 0; i < kPercents.size(); ++i) {
    summary.percentiles[i] = percentile(groups, summary.numbers, kPercents[i]);
  }
  summary.histogram = equal_bins(groups, summary.minimum, summary.maximum);
  return summary;
}

/// Counts every value of samples of 8 or 16 bits.
template <typename Sample>
class NarrowCounter {
 public:
  void add(Sample v) { ++counts_[static_cast<std::size_t>(v - std::numeric_limits<Sample>::lowest())]; }

  ValueSummary summary(double scale, double offset) const {
    std::vector<Group> groups;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      const double value = static_cast<double>(i) + std::numeric_limits<Sample>::lowest();
      if (counts_[i] > 0) groups.push_back({value, value, counts_[i]});
    }
    std::optional<std::vector<double>> distinct;
    if (groups.size() <= ValueSummary::kMostDistinct) {
      distinct.emplace();
      for (const Group& group : groups) distinct->push_back(scale * group.first + offset);
      std::sort(distinct->begin(), distinct->end());
    }
    ValueSummary summary = summarize(std::move(groups), scale, offset);
    summary.distinct = std::move(distinct);
    return summary;
  }

 private:
  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(std::size_t{1} << (8 * sizeof(Sample)));
};

/// Counts wider samples by the sign, the exponent and eight more bits of their value as a double.
template <typename Sample>
class WideCounter {
 public:
  void add(Sample sample) {
    const auto v = static_cast<double>(sample);
    if constexpr (std::is_floating_point_v<Sample>) {
      if (!std::isfinite(v)) {
        ++not_finite_;
        return;
      }
    }
    least_ = std::min(least_, v);
    greatest_ = std::max(greatest_, v);
    ++counts_[bin_of(v)];
    if (few_) see(v);
  }

  ValueSummary summary(double scale, double offset) const {
    if (few_) {
      ValueSummary summary = summarize(seen_, scale, offset);
      summary.not_finite = not_finite_;
      summary.distinct.emplace();
      for (const Group& group : seen_) summary.distinct->push_back(scale * group.first + offset);
      std::sort(summary.distinct->begin(), summary.distinct->end());
      return summary;
    }
    std::vector<Group> groups;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (counts_[i] == 0) continue;
      const double first = std::max(first_of(i), least_);
      const double last = std::min(i + 1 < counts_.size() ? first_of(i + 1) : greatest_, greatest_);
      // Beside 0 a group is of numbers so small that they are taken for 0.
      const auto kept = [](double v) { return std::fabs(v) < std::numeric_limits<double>::min() ? 0 : v; };
      groups.push_back({kept(first), kept(std::max(first, last)), counts_[i]});
    }
    ValueSummary summary = summarize(std::move(groups), scale, offset);
    summary.not_finite = not_finite_;
    return summary;
  }

 private:
  static constexpr int kShift = 44;

  /// Ascends with the value.
  static std::size_t bin_of(double v) {
    const auto bits = std::bit_cast<std::uint64_t>(v + 0.0);  // -0 as 0
    const std::uint64_t sign = std::uint64_t{1} << 63;
    return static_cast<std::size_t>(((bits & sign) != 0 ? ~bits : bits | sign) >> kShift);
  }
  static double first_of(std::size_t bin) {
    const std::uint64_t high = static_cast<std::uint64_t>(bin) << kShift, sign = std::uint64_t{1} << 63;
    return std::bit_cast<double>((high & sign) != 0 ? high & ~sign : ~high);
  }
  void see(double v) {
    // Neighbours are often equal.
    if (newest_ < seen_.size() && seen_[newest_].first == v) {
      ++seen_[newest_].count;
      return;
    }
    const auto place = std::lower_bound(seen_.begin(), seen_.end(), v,
                                        [](const Group& group, double value) { return group.first < value; });
    newest_ = static_cast<std::size_t>(place - seen_.begin());
    if (place != seen_.end() && place->first == v) {
      ++place->count;
    } else if (seen_.size() < ValueSummary::kMostDistinct) {
      seen_.insert(place, {v, v, 1});
    } else {
      few_ = false;
    }
  }

  std::vector<std::uint64_t> counts_ = std::vector<std::uint64_t>(std::size_t{1} << (64 - kShift));
  std::uint64_t not_finite_ = 0;
  double least_ = std::numeric_limits<double>::infinity(), greatest_ = -least_;
  std::vector<Group> seen_;  // each value, ascending
  std::size_t newest_ = 0;   // in seen_
  bool few_ = true;          // seen_ holds all
};

template <typename Sample>
using Counter = std::conditional_t<sizeof(Sample) <= 2, NarrowCounter<Sample>, WideCounter<Sample>>;

template <typename Sample>
Result<std::vector<ValueSummary>> survey(SliceReader& reader,
                                         const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  const VolumeDescription& d = reader.description();
  const auto components = static_cast<std::size_t>(d.components);
  std::vector<Counter<Sample>> counters(components);
  // A slice at a time would be slow where slices are small.
  constexpr std::uint64_t kBatchBytes = std::uint64_t{4} << 20;
  const std::uint64_t slice = slice_bytes(d), all = volume_bytes(d);
  const auto batch = static_cast<std::int64_t>(std::max<std::uint64_t>(1, kBatchBytes / slice));
  std::vector<std::byte> samples;
  for (std::int64_t z = 0; z < d.dimensions.z; z += batch) {
    const std::int64_t count = std::min(batch, d.dimensions.z - z);
    samples.resize(static_cast<std::size_t>(static_cast<std::uint64_t>(count) * slice));
    GVX_TRY(reader.read_slices(count, samples));
    for (std::size_t c = 0; c < components; ++c) {
      Counter<Sample>& counter = counters[c];
      for (std::size_t i = c; i < samples.size() / sizeof(Sample); i += components) {
        counter.add(sample_at<Sample>(samples, i));
      }
    }
    if (progress) progress(slice * static_cast<std::uint64_t>(z + count), all);
  }
  std::vector<ValueSummary> summaries;
  for (const Counter<Sample>& counter : counters) summaries.push_back(counter.summary(d.scale, d.offset));
  return summaries;
}

}  // namespace

Result<std::vector<ValueSummary>> survey_values(
    SliceReader& reader, const std::function<void(std::uint64_t done, std::uint64_t all)>& progress) {
  return with_sample_type(reader.description().type,
                          [&](auto sample) { return survey<decltype(sample)>(reader, progress); });
}

ValueSummary summary_of_bins(ValueRange stored, const std::vector<std::uint64_t>& bins, std::uint64_t voxels,
                             bool whole, double scale, double offset) {
  const double least = stored.minimum, width = stored.maximum - least;
  const auto count = static_cast<double>(bins.size());
  const bool tells_each = whole && width <= count;
  std::vector<Group> groups;
  std::vector<double> values;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (bins[i] == 0) continue;
    double first = least + width * static_cast<double>(i) / count;
    double last = least + width * static_cast<double>(i + 1) / count;
    if (tells_each) {
      first = last = i + 1 == bins.size() ? double(stored.maximum) : std::ceil(first);
      values.push_back(scale * first + offset);
    }
    groups.push_back({first, last, bins[i]});
  }
  ValueSummary summary = summarize(std::move(groups), scale, offset);
  if (summary.numbers == 0) return summary;
  summary.not_finite = voxels - std::min(voxels, summary.numbers);
  // Of a range bins say what is in it, not where it ends.
  const double ends[2] = {scale * least + offset, scale * stored.maximum + offset};
  summary.minimum = std::min(ends[0], ends[1]);
  summary.maximum = std::max(ends[0], ends[1]);
  if (tells_each && values.size() <= ValueSummary::kMostDistinct) {
    std::sort(values.begin(), values.end());
    summary.distinct = std::move(values);
  }
  return summary;
}

}  // namespace gvx::io
