#include "gvx/io/physical_values.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "gvx/io/sample_conversion.h"

namespace gvx::io {
namespace {

constexpr double kFloatRounding = 2e-7;

double physical_value(double sample, double scale, double offset) {
  const double value = scale * sample + offset;
  if (!std::isfinite(sample)) return sample;
  constexpr double kMost = std::numeric_limits<double>::max();
  if (!std::isfinite(value)) return value < 0 ? -kMost : kMost;
  const double whole = std::round(value);
  return std::abs(value - whole) <= kFloatRounding * std::abs(whole) ? whole : value;
}

}  // namespace

PhysicalValueReader::PhysicalValueReader(SliceReader& stored)
    : stored_(stored), description_(stored.description()) {
  description_.type = SampleType::f64;
  description_.scale = 1;
  description_.offset = 0;
}

Status PhysicalValueReader::read_slices(std::int64_t count, std::span<std::byte> out) {
  const VolumeDescription& d = stored_.description();
  const std::size_t values = slice_bytes(description_) / sizeof(double);
  samples_.resize(slice_bytes(d));
  for (; count > 0; --count) {
    GVX_TRY(stored_.read_slices(1, samples_));
    with_sample_type(d.type, [&](auto sample) {
      for (std::size_t i = 0; i < values; ++i) {
        const auto stored = static_cast<double>(sample_at<decltype(sample)>(samples_, i));
        const double value = physical_value(stored, d.scale, d.offset);
        std::memcpy(out.data() + i * sizeof(double), &value, sizeof(double));
      }
    });
    out = out.subspan(values * sizeof(double));
  }
  return {};
}

}  // namespace gvx::io
