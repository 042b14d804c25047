/// \file
/// From samples to voxels: a survey of the samples, the conversion that loses least of them, and the
/// conversion itself, which counts what it lost.
///
/// A float holds 24 bits. Samples with more bits stay apart where their range is small compared to their
/// size, such as 1e9, 1e9 + 0.5 and 1e9 + 1: a bias is subtracted before they are rounded.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>

#include "gvx/core/voxel.h"
#include "gvx/io/sample_type.h"

namespace gvx::io {

/// Holds every number of every sample type: integers of 64 bits have more digits than a double.
using Exact = long double;
static_assert(std::numeric_limits<Exact>::digits >= 64);

/// The type in which samples of a type are converted.
template <typename Sample>
using Reckoned = std::conditional_t<std::is_integral_v<Sample> && sizeof(Sample) == 8, Exact, double>;

/// Has the type numbers that a float rounds?
template <typename Sample>
inline constexpr bool kIsWide = sizeof(Sample) >= 4 && !std::is_same_v<Sample, float>;
inline bool is_wide(SampleType type) {
  return with_sample_type(type, [](auto sample) { return kIsWide<decltype(sample)>; });
}

/// From the least to the greatest of some numbers.
struct Span {
  Exact least = std::numeric_limits<Exact>::infinity();
  Exact greatest = -std::numeric_limits<Exact>::infinity();

  void include(const Span& other) {
    least = std::min(least, other.least);
    greatest = std::max(greatest, other.greatest);
  }
  bool empty() const { return least > greatest; }
  /// Is it short compared to its distance from 0?
  bool far_from_0() const { return !empty() && 4 * (greatest - least) <= std::max(least, -greatest); }
};

/// What a look at some samples finds.
struct Survey {
  Span finite;
  Span rounded;        ///< those that a float would round
  Exact fraction = 0;  ///< one that is not whole; 0 where all are

  void add(const Survey& other) {
    finite.include(other.finite);
    rounded.include(other.rounded);
    if (fraction == 0) fraction = other.fraction;
  }
};

/// Sample `i`, which need not be aligned.
template <typename Sample>
Sample sample_at(std::span<const std::byte> samples, std::size_t i) {
  Sample v;
  std::memcpy(&v, samples.data() + i * sizeof(Sample), sizeof(Sample));
  return v;
}

/// Surveys samples in native byte order.
template <typename Sample>
Survey survey_samples(std::span<const std::byte> samples) {
  constexpr Sample kMost = std::numeric_limits<Sample>::max(), kLeast = std::numeric_limits<Sample>::lowest();
  Sample least = kMost, greatest = kLeast, least_rounded = kMost, greatest_rounded = kLeast;
  Sample fraction = 0;
  bool any = false, any_rounded = false;
  for (std::size_t i = 0; i < samples.size() / sizeof(Sample); ++i) {
    const auto v = sample_at<Sample>(samples, i);
    if constexpr (std::is_floating_point_v<Sample>) {
      if (!std::isfinite(v)) continue;
      if (std::trunc(v) != v) fraction = v;
    }
    any = true;
    least = std::min(least, v);
    greatest = std::max(greatest, v);
    if constexpr (kIsWide<Sample>) {
      const auto exact = static_cast<Reckoned<Sample>>(v);
      if (static_cast<Reckoned<Sample>>(static_cast<float>(exact)) == exact) continue;
      any_rounded = true;
      least_rounded = std::min(least_rounded, v);
      greatest_rounded = std::max(greatest_rounded, v);
    }
  }
  Survey survey;
  survey.fraction = static_cast<Exact>(fraction);
  if (any) survey.finite = {static_cast<Exact>(least), static_cast<Exact>(greatest)};
  if (any_rounded) {
    survey.rounded = {static_cast<Exact>(least_rounded), static_cast<Exact>(greatest_rounded)};
  }
  return survey;
}

/// stored = (sample - bias) / unit, rounded, and clamped to the type's range.
struct Conversion {
  VoxelType type = VoxelType::u8;
  double bias = 0;
  double unit = 1;
};

/// The double at or just below a number.
inline double at_or_below(Exact number) {
  const auto near = static_cast<double>(number);
  return static_cast<Exact>(near) > number ? std::nextafter(near, -std::numeric_limits<double>::infinity())
                                           : near;
}

/// The float at or just below a number.
inline float float_at_or_below(Exact number) {
  const auto near = static_cast<float>(number);
  return static_cast<Exact>(near) > number ? std::nextafter(near, -std::numeric_limits<float>::infinity())
                                           : near;
}

/// To f32, with this bias taken off. The unit is 1 unless floats would be too large or too small to reckon
/// with.
inline Conversion to_float(const Survey& survey, double bias) {
  constexpr double kLargest = 0x1p126, kSmallest = 0x1p-100;
  if (survey.rounded.empty()) return {VoxelType::f32, 0, 1};
  const auto most = static_cast<double>(
      std::max(std::abs(survey.finite.least - bias), std::abs(survey.finite.greatest - bias)));
  const bool fits = most == 0 || (most >= kSmallest && most <= kLargest);
  return {VoxelType::f32, bias, fits ? 1 : std::ldexp(1.0, std::max(std::ilogb(most), -1000))};
}

/// To u8 or u16: equal steps over the whole range, or whole numbers where integers fit.
inline Conversion to_integer(SampleType from, const Survey& survey, VoxelType to) {
  if (survey.finite.empty()) return {to, 0, 1};
  const Exact steps = to == VoxelType::u8 ? 255 : 65535;
  const double bias = at_or_below(survey.finite.least);
  const Exact unit = survey.finite.greatest / steps - bias / steps;
  const bool integers = from != SampleType::f32 && from != SampleType::f64;
  return {to, bias, unit <= 0 || (integers && unit <= 1) ? 1 : static_cast<double>(unit)};
}

/// What a conversion did to some samples.
struct ConversionAccount {
  std::uint64_t not_finite = 0;  ///< NaN or infinite
  std::uint64_t infinite = 0;    ///< of them
  std::uint64_t clamped = 0;     ///< lay beyond what the voxel type holds
  std::uint64_t rounded = 0;     ///< are not held to the last digit by f32
  double rounded_by = 0;         ///< the most that one of them was changed by
  Span rounded_samples;

  void add(const ConversionAccount& other) {
    not_finite += other.not_finite;
    infinite += other.infinite;
    clamped += other.clamped;
    rounded += other.rounded;
    rounded_by = std::max(rounded_by, other.rounded_by);
    rounded_samples.include(other.rounded_samples);
  }
};

/// Converts all samples; those that are not finite become `no_data`.
template <typename Sample, typename Voxel>
ConversionAccount convert_samples(std::span<const std::byte> samples, const Conversion& c, Voxel no_data,
                                  Voxel* out) {
  using Number = Reckoned<Sample>;
  constexpr auto kMost = static_cast<Number>(std::numeric_limits<Voxel>::max());
  constexpr auto kLeast = static_cast<Number>(std::numeric_limits<Voxel>::lowest());
  const auto bias = static_cast<Number>(c.bias), unit = static_cast<Number>(c.unit);
  ConversionAccount account;
  for (std::size_t i = 0; i < samples.size() / sizeof(Sample); ++i) {
    const auto sample = static_cast<Number>(sample_at<Sample>(samples, i));
    if constexpr (std::is_floating_point_v<Sample>) {
      if (!std::isfinite(sample)) {
        ++account.not_finite;
        account.infinite += std::isinf(sample) ? 1 : 0;
        out[i] = no_data;
        continue;
      }
    }
    Number stored = (sample - bias) / unit;
    if constexpr (std::is_integral_v<Voxel>) stored = std::nearbyint(stored);
    if (stored < kLeast || stored > kMost) {
      ++account.clamped;
      stored = std::clamp(stored, kLeast, kMost);
    }
    out[i] = static_cast<Voxel>(stored);
    if constexpr (kIsWide<Sample> && std::is_same_v<Voxel, float>) {
      const Number lost = std::abs(static_cast<Number>(out[i]) - stored);
      if (lost == 0) continue;
      ++account.rounded;
      account.rounded_by = std::max(account.rounded_by, static_cast<double>(lost * unit));
      account.rounded_samples.include({static_cast<Exact>(sample), static_cast<Exact>(sample)});
    }
  }
  return account;
}

}  // namespace gvx::io
