/// \file
/// Samples: values of known distributions, and their statistics as a store has them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "gvx/scene/value_statistics.h"

namespace gvx::scene {

class Samples {
 public:
  void add(double value, int count = 1) {
    values_.insert(values_.end(), static_cast<std::size_t>(count), value);
  }
  void add_normal(int count, double mean, double deviation) {
    std::normal_distribution<double> normal(mean, deviation);
    for (int i = 0; i < count; ++i) values_.push_back(normal(random_));
  }
  /// As the magnitude of two normal numbers: the noise of MR and ultrasound where there is no signal.
  void add_rayleigh(int count, double deviation) {
    std::normal_distribution<double> normal(0, deviation);
    for (int i = 0; i < count; ++i) values_.push_back(std::hypot(normal(random_), normal(random_)));
  }
  const std::vector<double>& values() const { return values_; }

  ValueStatistics statistics() const {
    constexpr std::size_t kBins = 1024;
    const auto [least, greatest] = std::minmax_element(values_.begin(), values_.end());
    ValueStatistics s{*least, *greatest, std::vector<std::uint64_t>(kBins)};
    for (const double value : values_) {
      const double bin = (value - s.minimum) / (s.maximum - s.minimum) * double(kBins);
      ++s.histogram[std::min(static_cast<std::size_t>(bin), kBins - 1)];
    }
    return s;
  }

 private:
  std::mt19937 random_{5};
  std::vector<double> values_;
};

}  // namespace gvx::scene
