#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "gvx/scene/transfer_function.h"

namespace gvx::scene {
namespace {

constexpr std::array<const char*, 10> kNames = {"ct-bone", "ct-skin", "ct-tissue", "mr",    "microscopy",
                                                "gray",    "solid",   "inside",    "cloud", "ramp"};

/// Within so much of the values' span a function rises where next to all of them are one.
constexpr double kLeastRise = 1e-3;

/// The physical value below which `share` of the voxels lie.
double percentile(const ValueStatistics& s, double share) {
  const double all =
      static_cast<double>(std::accumulate(s.histogram.begin(), s.histogram.end(), std::uint64_t(0)));
  double below = 0;
  for (std::size_t i = 0; i < s.histogram.size(); ++i) {
    below += static_cast<double>(s.histogram[i]);
    if (below >= share * all) {
      return s.minimum +
             (s.maximum - s.minimum) * static_cast<double>(i + 1) / static_cast<double>(s.histogram.size());
    }
  }
  return s.maximum;
}

/// Of the values; where there is but one, something that is small beside it.
double width_of(const ValueStatistics& s) {
  const double width = s.maximum - s.minimum;
  if (width > 0) return width;
  return s.minimum != 0 ? 1e-3 * std::abs(s.minimum) : 1;
}

TransferFunction ct_bone() {
  return {
      {{150, {0.62, 0.32, 0.22}}, {350, {0.88, 0.74, 0.57}}, {900, {0.97, 0.92, 0.82}}, {2000, {1, 1, 0.97}}},
      {{140, 0}, {260, 0.25}, {500, 0.7}, {1200, 0.9}},
      0};
}

TransferFunction ct_skin() {
  return {{{-500, {0.72, 0.46, 0.36}},
           {-150, {0.87, 0.65, 0.54}},
           {150, {0.95, 0.80, 0.70}},
           {600, {1, 0.95, 0.88}}},
          {{-480, 0}, {-250, 0.35}, {0, 0.6}, {400, 0.9}},
          0};
}

TransferFunction ct_tissue() {
  return {{{-300, {0.80, 0.52, 0.40}},
           {40, {0.78, 0.30, 0.24}},
           {160, {0.86, 0.55, 0.38}},
           {350, {0.95, 0.90, 0.80}}},
          {{-350, 0}, {-180, 0.015}, {20, 0.02}, {90, 0.03}, {180, 0.12}, {400, 0.6}},
          0};
}

/// A ramp from the dark half of the voxels to the brightest thousandth.
TransferFunction gray(const ValueStatistics& s) {
  const double width = width_of(s);
  const double floor = s.histogram.empty() ? s.minimum + 0.15 * width : percentile(s, 0.6);
  const double top = s.histogram.empty() ? s.maximum : percentile(s, 0.999);
  const double low = std::min(floor, s.minimum + 0.5 * width), high = std::max(top, low + 0.05 * width);
  return {{{low, {0.45, 0.42, 0.40}}, {0.5 * (low + high), {0.85, 0.80, 0.74}}, {high, {1, 1, 1}}},
          {{low, 0}, {low + 0.25 * (high - low), 0.05}, {high, 0.6}},
          0};
}

/// The value that parts the histogram into the two most compact groups (Otsu 1979); the middle where there is
/// none.
double otsu_threshold(const ValueStatistics& s) {
  const std::size_t bins = s.histogram.size();
  double all = 0, moment = 0;
  for (std::size_t i = 0; i < bins; ++i) {
    all += static_cast<double>(s.histogram[i]);
    moment += static_cast<double>(i) * static_cast<double>(s.histogram[i]);
  }
  double best = -1, below = 0, below_moment = 0;
  std::size_t first = bins / 2, last = first;  // equally good bins: an empty valley
  for (std::size_t i = 0; i + 1 < bins; ++i) {
    below += static_cast<double>(s.histogram[i]);
    below_moment += static_cast<double>(i) * static_cast<double>(s.histogram[i]);
    if (below <= 0 || below >= all) continue;
    const double apart = below_moment / below - (moment - below_moment) / (all - below);
    const double between = below * (all - below) * apart * apart;
    if (between > best * (1 + 1e-12)) {
      best = between;
      first = i;
    }
    if (between >= best * (1 - 1e-12)) last = i;
  }
  const double place =
      bins > 0 ? (0.5 * static_cast<double>(first + last) + 1) / static_cast<double>(bins) : 0.5;
  return s.minimum + place * (s.maximum - s.minimum);
}

/// A head from outside: what is brighter than air.
TransferFunction mr(const ValueStatistics& s) {
  const double air = s.minimum, tissue = otsu_threshold(s);
  const double top =
      std::max(s.histogram.empty() ? s.maximum : percentile(s, 0.998), tissue + kLeastRise * width_of(s));
  const auto at = [&](double share) { return air + share * (tissue - air); };
  return {{{at(0.4), {0.55, 0.36, 0.30}},
           {at(1), {0.80, 0.62, 0.52}},
           {0.5 * (tissue + top), {0.93, 0.84, 0.74}},
           {top, {1, 0.98, 0.93}}},
          {{at(0.45), 0}, {at(0.9), 0.25}, {at(1.2), 0.5}, {std::max(top, at(1.3)), 0.9}},
          0};
}

/// Light from the brightest few per cent, one hue a channel; nothing hides much of what is behind it.
TransferFunction microscopy(const ValueStatistics& s) {
  constexpr std::array<Vec3d, 4> kHues = {Vec3d(0.25, 1, 0.35), Vec3d(1, 0.2, 0.9), Vec3d(0.25, 0.75, 1),
                                          Vec3d(1, 0.85, 0.2)};
  const Vec3d hue = s.channels > 1 ? kHues[s.channel % 4] : Vec3d(0.55, 1, 0.75);
  const double width = width_of(s);
  const double low = s.histogram.empty() ? s.minimum + 0.2 * width : percentile(s, 0.85);
  const double high = std::max(s.histogram.empty() ? s.maximum : percentile(s, 0.9995), low + 0.02 * width);
  return {{{low, 0.35 * hue}, {0.5 * (low + high), 0.8 * hue}, {high, 0.4 * hue + Vec3d(0.6)}},
          {{low, 0}, {low + 0.4 * (high - low), 0.02}, {high, 0.25}},
          0};
}

/// Black to white and opaque, for projections.
TransferFunction ramp(const ValueStatistics& s) {
  const double low = s.histogram.empty() ? s.minimum : percentile(s, 0.005);
  const double high = s.histogram.empty() ? s.maximum : percentile(s, 0.9998);
  return {{{low, {0, 0, 0}}, {std::max(high, low + kLeastRise * width_of(s)), {1, 1, 1}}}, {{low, 1}}, 0};
}

/// What is above the middle of the values, as a surface.
TransferFunction solid(const ValueStatistics& s) {
  const double width = width_of(s);
  const auto at = [&](double share) { return s.minimum + share * width; };
  return {{{at(0), {0.80, 0.72, 0.60}}, {at(1), {0.95, 0.90, 0.82}}}, {{at(0.3), 0}, {at(0.6), 0.9}}, 0};
}

/// What is below the middle of the values: of distances to a surface, what it encloses.
TransferFunction inside(const ValueStatistics& s) {
  const double width = width_of(s), middle = 0.5 * (s.minimum + s.maximum);
  return {{{s.minimum, {0.95, 0.90, 0.82}}, {s.maximum, {0.80, 0.72, 0.60}}},
          {{middle - 0.01 * width, 0.9}, {middle + 0.01 * width, 0}},
          0};
}

/// White haze, the denser the more opaque.
TransferFunction cloud(const ValueStatistics& s) {
  const double width = width_of(s);
  return {{{s.minimum, {0.93, 0.95, 1}}, {s.maximum, {1, 1, 1}}},
          {{s.minimum, 0}, {s.minimum + width, 0.035}},
          0};
}

}  // namespace

std::span<const char* const> preset_names() {
  return kNames;
}

TransferFunction label_colors(std::uint32_t labels) {
  // Hues a golden section apart, three degrees of lightness in turn.
  constexpr double kGolden = 0.618033988749895;
  TransferFunction function;
  function.opacities = {{0, 0}, {0.5, 0}, {0.5, 0.9}};
  for (std::uint32_t label = 0; label < std::max(labels, 1u); ++label) {
    const double hue = 6 * std::fmod(0.1 + kGolden * label, 1.0), light = 0.95 - 0.2 * (label / 7 % 3);
    const auto part = [&](double shift) {
      const double h = std::fmod(hue + shift, 6.0);
      return light * (0.25 + 0.75 * std::clamp(std::abs(h - 3) - 1, 0.0, 1.0));
    };
    function.colors.push_back({double(label), {part(0), part(4), part(2)}});
  }
  return function;
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

Result<TransferFunction> preset(const std::string& name, const ValueStatistics& statistics) {
  if (name == "ct-bone") return ct_bone();
  if (name == "ct-skin") return ct_skin();
  if (name == "ct-tissue") return ct_tissue();
  if (name == "mr") return mr(statistics);
  if (name == "microscopy") return microscopy(statistics);
  if (name == "ramp") return ramp(statistics);
  if (name == "gray") return gray(statistics);
  if (name == "solid") return solid(statistics);
  if (name == "inside") return inside(statistics);
  if (name == "cloud") return cloud(statistics);
  std::string known;
  for (const char* n : kNames) known += std::string(known.empty() ? "" : ", ") + n;
  return Error{"transfer function: no preset '" + name + "'; there are " + known};
}

std::string suggest_preset(const ValueStatistics& s) {
  const bool hounsfield = s.minimum <= -500 && s.minimum >= -4096 && s.maximum >= 700 && s.maximum <= 32767;
  if (hounsfield && s.channels == 1) return "ct-bone";
  if (s.channels > 1) return "microscopy";
  return s.anatomical && s.minimum >= 0 ? "mr" : "gray";
}

}  // namespace gvx::scene
