#include "gvx/scene/label_table.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gvx::scene {
namespace {

constexpr double kOpacity = 0.9;

/// Hues a golden section apart; saturation and value in turn. These turns were searched for: of the first 12
/// labels all are at least 28 units of CIE L*a*b* apart, of the first 50 at least 9.
Vec3d color_of(std::uint32_t label) {
  constexpr double kGolden = 0.618033988749895, kFirstHue = 0.35;
  constexpr std::array<double, 6> kSaturations = {0.64, 0.53, 0.83, 0.80, 0.70, 0.33};
  constexpr std::array<double, 6> kValues = {0.65, 0.98, 0.98, 0.87, 0.84, 0.78};
  const double hue = 6 * std::fmod(kFirstHue + kGolden * label, 1.0);
  const double saturation = kSaturations[label % kSaturations.size()];
  const auto part = [&](double shift) {
    const double h = std::fmod(hue + shift, 6.0);
    const double share = 1 - saturation + saturation * std::clamp(std::abs(h - 3) - 1, 0.0, 1.0);
    return kValues[label % kValues.size()] * share;
  };
  return {part(0), part(4), part(2)};
}

}  // namespace

TransferFunction label_colors(std::uint32_t labels) {
  TransferFunction function;
  function.opacities = {{0, 0}, {0.5, 0}, {0.5, kOpacity}};
  for (std::uint32_t label = 0; label < std::max(labels, 1u); ++label) {
    function.colors.push_back({double(label), color_of(label)});
  }
  return function;
}

TransferFunction label_colors(std::uint32_t labels, const LabelTable& table) {
  TransferFunction function = label_colors(labels);
  function.opacities = {{0, 0}};
  for (std::uint32_t label = 1; label < std::max(labels, 2u); ++label) {
    function.opacities.push_back({double(label), kOpacity});
  }
  for (const auto& [label, entry] : table) {
    if (label == 0 || label >= labels) continue;
    if (entry.color) function.colors[label].color = *entry.color;
    function.opacities[label].opacity = kOpacity * entry.opacity;
  }
  return function;
}

}  // namespace gvx::scene
