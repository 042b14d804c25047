#include "gvx/scene/fitted_presets.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gvx::scene {
namespace {

/// Within so much of the values' span a function rises where next to all of them are one.
constexpr double kLeastRise = 1e-3;

/// Rises from background to object, colours from a border to the brightest.
struct Border {
  double start;   ///< background and its noise lie below
  double object;  ///< half way from background to object
  double top;     ///< of the object, but for outliers
};

Border border(const ValueStatistics& s) {
  // The share of the way from background to threshold up to which there may be noise, or air that a voxel has
  // a part of.
  constexpr double kPartial = 0.45, kMostNoise = 0.8;
  const double least = kLeastRise * s.width();
  if (s.histogram.empty()) {
    const double middle = 0.5 * (s.minimum + s.maximum);
    return {s.minimum + kPartial * (middle - s.minimum), middle, std::max(s.maximum, middle + least)};
  }
  const HistogramShape shape = histogram_shape(s);
  const double way = std::max(shape.threshold - shape.background, least);
  const double start =
      shape.background + std::clamp(shape.noise_top - shape.background, kPartial * way, kMostNoise * way);
  const double object = shape.background + way;
  return {start, object, std::max(shape.top, object + 0.3 * way)};
}

/// Four of each: at the start, a little before the object, a little above it, and at the top.
struct Looks {
  std::array<Vec3d, 4> colors;
  std::array<double, 4> opacities;
};

TransferFunction rising(const Border& b, const Looks& looks, double unit_distance) {
  const double rise = b.object - b.start;
  const std::array<double, 4> color_values = {b.start, b.object, 0.5 * (b.object + b.top), b.top};
  const std::array<double, 4> values = {b.start, b.start + 0.8 * rise, std::min(b.start + 1.35 * rise, b.top),
                                        b.top};
  TransferFunction function;
  for (std::size_t i = 0; i < 4; ++i) {
    function.colors.push_back({color_values[i], looks.colors[i]});
    function.opacities.push_back({values[i], looks.opacities[i]});
  }
  function.unit_distance = unit_distance;
  return function;
}

}  // namespace

TransferFunction mr_function(const ValueStatistics& s) {
  return rising(
      border(s),
      {{Vec3d(0.66, 0.46, 0.38), Vec3d(0.85, 0.68, 0.58), Vec3d(0.95, 0.86, 0.77), Vec3d(1, 0.98, 0.93)},
       {0, 0.25, 0.5, 0.9}},
      0);
}

TransferFunction surface_function(const ValueStatistics& s) {
  // A wall a hundredth of the volume thick lets through what is behind it.
  constexpr double kUnits = 64;
  return rising(
      border(s),
      {{Vec3d(0.60, 0.47, 0.36), Vec3d(0.82, 0.69, 0.53), Vec3d(0.93, 0.85, 0.72), Vec3d(1, 0.97, 0.90)},
       {0, 0.03, 0.12, 0.5}},
      s.size_world / kUnits);
}

TransferFunction layers_function(const ValueStatistics& s) {
  struct Layer {
    double share;  ///< of the voxels above the floor that lie below it
    Vec3d color;
    double opacity;
  };
  constexpr std::array<Layer, 6> kLayers = {
      Layer{0, {0.24, 0.24, 0.60}, 0},        Layer{0.25, {0.20, 0.38, 0.72}, 0.01},
      Layer{0.55, {0.13, 0.58, 0.68}, 0.035}, Layer{0.8, {0.30, 0.76, 0.48}, 0.1},
      Layer{0.95, {0.92, 0.84, 0.28}, 0.3},   Layer{0.998, {1.0, 0.52, 0.22}, 0.6}};
  constexpr double kUnits = 48, kFloor = 0.02, kMostNoise = 0.3;
  double floor = s.minimum + kFloor * s.width();
  if (!s.histogram.empty()) {
    const HistogramShape shape = histogram_shape(s);
    const double way = std::max(shape.top - shape.background, kLeastRise * s.width());
    floor = shape.background + std::clamp(shape.noise_top - shape.background, kFloor * way, kMostNoise * way);
  }
  TransferFunction function;
  // Rays go through what is seen, which may be a small part of the volume.
  function.unit_distance = s.size_world * std::cbrt(share_above(s, floor)) / kUnits;
  double before = floor;
  for (const Layer& layer : kLayers) {
    const double share = s.histogram.empty() ? floor + layer.share * (s.maximum - floor)
                                             : percentile_above(s, floor, layer.share);
    before = layer.share > 0 ? std::max(share, before + kLeastRise * s.width()) : floor;
    function.colors.push_back({before, layer.color});
    function.opacities.push_back({before, layer.opacity});
  }
  return function;
}

TransferFunction diverging_function(const ValueStatistics& s) {
  constexpr double kOutliers = 1e-3, kUnits = 64;
  const double most = std::max(
      {std::abs(s.percentile(kOutliers)), std::abs(s.percentile(1 - kOutliers)), kLeastRise * s.width()});
  // Voxels that are exactly zero are around the object; of what is left, three quarters are within 1.15
  // standard deviations if it is noise.
  double inner = 0.25 * most;
  if (!s.histogram.empty()) {
    const double bin = s.width() / static_cast<double>(s.histogram.size());
    const double above = percentile_above(s, std::min(2 * bin, s.maximum), 0.5);
    inner = std::clamp(3.0 * above / 0.6745, 0.15 * most, 0.4 * most);
  }
  const double middle = 0.5 * (inner + most);
  TransferFunction function;
  function.colors = {{-most, {0.55, 0.90, 1.0}},  {-middle, {0.20, 0.55, 0.95}}, {-inner, {0.13, 0.28, 0.80}},
                     {inner, {0.75, 0.13, 0.15}}, {middle, {0.95, 0.42, 0.15}},  {most, {1.0, 0.88, 0.40}}};
  function.opacities = {{-most, 0.6}, {-middle, 0.3}, {-inner, 0}, {inner, 0}, {middle, 0.3}, {most, 0.6}};
  function.unit_distance = s.size_world / kUnits;
  return function;
}

TransferFunction microscopy_function(const ValueStatistics& s) {
  constexpr std::array<Vec3d, 4> kHues = {Vec3d(0.25, 1, 0.35), Vec3d(1, 0.2, 0.9), Vec3d(0.25, 0.75, 1),
                                          Vec3d(1, 0.85, 0.2)};
  constexpr double kUnits = 200;
  const Vec3d hue = s.color.value_or(s.channels > 1 ? kHues[s.channel % 4] : Vec3d(0.55, 1, 0.75));
  const double width = s.width();
  double low = s.minimum + 0.2 * width, high = s.maximum;
  if (!s.histogram.empty()) {
    low = std::max(s.percentile(0.85), std::min(histogram_shape(s).noise_top, s.percentile(0.98)));
    high = s.percentile(0.9995);
  }
  high = std::max(high, low + 0.02 * width);
  return {{{low, 0.35 * hue}, {0.5 * (low + high), 0.8 * hue}, {high, 0.4 * hue + Vec3d(0.6)}},
          {{low, 0}, {low + 0.4 * (high - low), 0.02}, {high, 0.25}},
          s.size_world / kUnits};
}

bool is_around_zero(const ValueStatistics& s) {
  constexpr double kOutliers = 1e-3, kLeastOther = 0.15, kNear = 0.05;
  if (s.histogram.empty() || !(s.minimum < 0 && s.maximum > 0)) return false;
  const double below = -s.percentile(kOutliers), above = s.percentile(1 - kOutliers);
  const double most = std::max(below, above);
  if (!(std::min(below, above) > kLeastOther * most)) return false;
  return std::abs(s.percentile(0.5)) < kNear * most;
}

bool has_surface(const ValueStatistics& s) {
  constexpr double kLeastSeparation = 0.84;
  return !s.histogram.empty() && histogram_shape(s).separation >= kLeastSeparation;
}

}  // namespace gvx::scene
