#include "gvx/scene/transfer_function.h"

#include <algorithm>
#include <cmath>

namespace gvx::scene {
namespace {

/// Linear interpolation in points sorted by .value; of two points of one value the later holds from there on.
template <typename Point, typename Member>
auto interpolate(const std::vector<Point>& points, double value, Member member) {
  const auto after = std::upper_bound(points.begin(), points.end(), value,
                                      [](double v, const Point& p) { return v < p.value; });
  if (after == points.begin()) return points.front().*member;
  if (after == points.end()) return points.back().*member;
  const auto before = after - 1;
  const double weight = (value - before->value) / (after->value - before->value);
  return (*before).*member + weight * ((*after).*member - (*before).*member);
}

}  // namespace

Vec3d TransferFunction::color(double value) const {
  return interpolate(colors, value, &ColorPoint::color);
}

double TransferFunction::opacity(double value) const {
  return interpolate(opacities, value, &OpacityPoint::opacity);
}

bool TransferFunction::transparent(double minimum, double maximum) const {
  if (opacity(minimum) > 0 || opacity(maximum) > 0) return false;
  return std::none_of(opacities.begin(), opacities.end(), [&](const OpacityPoint& p) {
    return p.value >= minimum && p.value <= maximum && p.opacity > 0;
  });
}

Status check(const TransferFunction& function) {
  const auto bad = [](const char* list, std::size_t i, const char* what) {
    return Error{std::string("transfer function: ") + list + " point " + std::to_string(i + 1) + " " + what};
  };
  if (function.colors.empty()) return Error{"transfer function: no colour points"};
  if (function.opacities.empty()) return Error{"transfer function: no opacity points"};
  for (std::size_t i = 0; i < function.colors.size(); ++i) {
    const ColorPoint& p = function.colors[i];
    if (!std::isfinite(p.value)) return bad("colour", i, "has no finite value");
    if (i > 0 && p.value < function.colors[i - 1].value)
      return bad("colour", i, "is below the one before it");
    for (int c = 0; c < 3; ++c) {
      if (!(p.color[c] >= 0 && p.color[c] <= 1)) return bad("colour", i, "has a component outside 0 to 1");
    }
  }
  for (std::size_t i = 0; i < function.opacities.size(); ++i) {
    const OpacityPoint& p = function.opacities[i];
    if (!std::isfinite(p.value)) return bad("opacity", i, "has no finite value");
    if (i > 0 && p.value < function.opacities[i - 1].value)
      return bad("opacity", i, "is below the one before it");
    if (!(p.opacity >= 0 && p.opacity <= 1)) return bad("opacity", i, "is outside 0 to 1");
  }
  if (!(function.unit_distance >= 0) || !std::isfinite(function.unit_distance)) {
    return Error{"transfer function: the unit distance must be a length, or 0 for one voxel"};
  }
  return {};
}

TransferTable bake(const TransferFunction& function, double scale, double offset,
                   std::span<const double> step_units) {
  constexpr int kEntries = TransferView::kEntries;
  const double first = std::min(function.colors.front().value, function.opacities.front().value);
  double last = std::max(function.colors.back().value, function.opacities.back().value);
  if (!(last > first)) last = first + std::max(1.0, std::abs(first)) * 1e-6;
  TransferTable table;
  table.to_entry_scale = static_cast<float>(scale * (kEntries - 1) / (last - first));
  table.to_entry_offset = static_cast<float>((offset - first) * (kEntries - 1) / (last - first));
  table.opaque_before.push_back(0);
  std::vector<double> opacities;
  for (int i = 0; i < kEntries; ++i) {
    const double value = first + (last - first) * i / (kEntries - 1);
    table.colors.push_back(Vec3f(function.color(value)));
    opacities.push_back(function.opacity(value));
    table.opaque_before.push_back(table.opaque_before.back() + (opacities.back() > 0 ? 1 : 0));
  }
  for (const double units : step_units) {
    for (const double opacity : opacities) {
      table.opacities.push_back(static_cast<float>(-std::expm1(units * std::log1p(-opacity))));
    }
  }
  return table;
}

}  // namespace gvx::scene
