#include "value_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "gvx/io/header_text.h"

namespace gvx::app {
namespace {

constexpr std::size_t kColumns = 50, kLines = 6;
constexpr std::size_t kMostListed = 24;

/// Six digits: what a person compares with others.
std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

/// The part of the range that most values are in; all of it where that is no small part.
std::pair<double, double> shown_range(const io::ValueSummary& s) {
  const double low = s.percentiles.front(), high = s.percentiles.back();
  const bool far_ends = high > low && 4 * (high - low) < s.maximum - s.minimum;
  return far_ends ? std::pair(low, high) : std::pair(s.minimum, s.maximum);
}

/// Of counts in columns over a range that lies in the histogram's.
std::vector<double> columns(const io::ValueSummary& s, double from, double to) {
  std::vector<double> counts(kColumns);
  const auto bins = static_cast<double>(s.histogram.size());
  const double per_bin = (s.maximum - s.minimum) / bins;
  if (!(to > from) || !(per_bin > 0)) {
    counts[0] = static_cast<double>(s.numbers);
    return counts;
  }
  const double per_column = (to - from) / kColumns;
  for (std::size_t bin = 0; bin < s.histogram.size(); ++bin) {
    if (s.histogram[bin] == 0) continue;
    const double left = s.minimum + per_bin * static_cast<double>(bin);
    if (per_bin <= per_column) {
      const double column = std::floor((left + per_bin / 2 - from) / per_column);
      if (column >= 0 && column < kColumns) {
        counts[static_cast<std::size_t>(column)] += static_cast<double>(s.histogram[bin]);
      }
      continue;
    }
    for (std::size_t column = 0; column < kColumns; ++column) {
      const double begin = std::max(left, from + per_column * static_cast<double>(column));
      const double end = std::min(left + per_bin, from + per_column * static_cast<double>(column + 1));
      counts[column] += std::max(0.0, end - begin) / per_bin * static_cast<double>(s.histogram[bin]);
    }
  }
  return counts;
}

void add_histogram(const io::ValueSummary& s, std::vector<Row>& rows) {
  const auto [from, to] = shown_range(s);
  const std::vector<double> counts = columns(s, from, to);
  const double most = std::log1p(*std::max_element(counts.begin(), counts.end()));
  rows.emplace_back("histogram", "how many voxels, on a logarithmic scale");
  for (std::size_t line = 0; line < kLines; ++line) {
    std::string text = "|";
    for (const double count : counts) {
      // What is there at all is seen.
      const double height = count > 0 ? std::max(1.0, std::round(kLines * std::log1p(count) / most)) : 0;
      text += height >= static_cast<double>(kLines - line) ? '#' : ' ';
    }
    text.resize(text.find_last_not_of(' ') + 1);
    rows.emplace_back("", text);
  }
  rows.emplace_back("", "+" + std::string(kColumns, '-'));
  const std::string left = short_text(from), right = short_text(to);
  const std::size_t gap = kColumns > left.size() + right.size() ? kColumns - left.size() - right.size() : 1;
  rows.emplace_back("", " " + left + std::string(gap, ' ') + right);
}

std::string percent_text(double percent) {
  return io::number_text(percent);
}

}  // namespace

std::vector<Row> value_rows(const io::ValueSummary& s) {
  std::vector<Row> rows;
  if (s.numbers == 0) {
    rows.emplace_back("values", "none: every voxel is NaN or infinite");
    return rows;
  }
  rows.emplace_back("values", io::number_text(s.minimum) + " to " + io::number_text(s.maximum));
  std::string text;
  for (std::size_t i = 0; i < io::kPercents.size(); ++i) {
    text += (i == 0 ? "" : ", ") + percent_text(io::kPercents[i]) + " %: " + short_text(s.percentiles[i]);
  }
  rows.emplace_back("percentiles", text);
  if (s.distinct && s.distinct->size() > 0) {
    text = std::to_string(s.distinct->size());
    for (std::size_t i = 0; i < s.distinct->size() && s.distinct->size() <= kMostListed; ++i) {
      text += (i == 0 ? ": " : ", ") + short_text((*s.distinct)[i]);
    }
    rows.emplace_back("distinct", text);
  }
  if (s.not_finite > 0) {
    const double share = static_cast<double>(s.not_finite) / static_cast<double>(s.numbers + s.not_finite);
    rows.emplace_back("no data", std::to_string(s.not_finite) + " voxels that are NaN or infinite (" +
                                     short_text(std::round(1e4 * share) / 100) + " %)");
  }
  add_histogram(s, rows);
  return rows;
}

nlohmann::json value_json(const io::ValueSummary& s) {
  nlohmann::json j = {{"numbers", s.numbers}, {"not_finite", s.not_finite}};
  if (s.numbers == 0) return j;
  j["minimum"] = s.minimum;
  j["maximum"] = s.maximum;
  for (std::size_t i = 0; i < io::kPercents.size(); ++i) {
    j["percentiles"][percent_text(io::kPercents[i])] = s.percentiles[i];
  }
  if (s.distinct) j["distinct"] = *s.distinct;
  j["histogram"] = s.histogram;
  return j;
}

}  // namespace gvx::app
