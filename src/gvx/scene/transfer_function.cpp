#include "gvx/scene/transfer_function.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gvx/scene/even_means.h"

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

double TransferFunction::gradient_factor(double gradient) const {
  if (gradients.empty()) return 1;
  const auto after = std::upper_bound(gradients.begin(), gradients.end(), gradient,
                                      [](double g, const GradientPoint& p) { return g < p.gradient; });
  if (after == gradients.begin()) return gradients.front().factor;
  if (after == gradients.end()) return gradients.back().factor;
  const auto before = after - 1;
  const double weight = (gradient - before->gradient) / (after->gradient - before->gradient);
  return before->factor + weight * (after->factor - before->factor);
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
  for (std::size_t i = 0; i < function.gradients.size(); ++i) {
    const GradientPoint& p = function.gradients[i];
    if (!(p.gradient >= 0) || !std::isfinite(p.gradient)) return bad("gradient", i, "is not 0 or more");
    if (i > 0 && p.gradient < function.gradients[i - 1].gradient)
      return bad("gradient", i, "is below the one before it");
    if (!(p.factor >= 0 && p.factor <= 1)) return bad("gradient", i, "has a factor outside 0 to 1");
  }
  if (!(function.unit_distance >= 0 && function.unit_distance <= 1e12)) {
    return Error{"transfer function: the unit distance must be a length, or 0 for one voxel"};
  }
  return {};
}

namespace {

// Of an opaque label: nothing is seen through a thousandth of the unit distance.
constexpr double kOpaqueLabel = 8000;

/// The function's matter at a physical value.
Matter matter_at(const TransferFunction& function, double value, double most_extinction) {
  const double extinction = std::min(-std::log1p(-function.opacity(value)), most_extinction);
  return {Vec3f(extinction * function.color(value)), static_cast<float>(extinction)};
}

void count_visible(TransferTable& table) {
  const auto seen = [](const Matter& m) { return m.extinction > 0; };
  const auto first = std::find_if(table.matter.begin(), table.matter.end(), seen);
  const auto last = std::find_if(table.matter.rbegin(), table.matter.rend(), seen);
  constexpr float kBeyond = 1e30f;
  const auto end = static_cast<float>(table.matter.size());
  // Between an entry that is seen and one that is not, some is; the ends go on for ever.
  const auto from = static_cast<float>(first - table.matter.begin()) - 1;
  const float to = end - static_cast<float>(last - table.matter.rbegin());
  table.first_visible = from < 0 ? -kBeyond : from;
  table.last_visible = to >= end ? kBeyond : to;
  table.visible_before.push_back(0);
  for (const Matter& m : table.matter) {
    table.visible_before.push_back(table.visible_before.back() + (m.extinction > 0 ? 1 : 0));
  }
}

/// Where a function's slopes may change, in entries of a table.
std::vector<double> stops_of(const TransferFunction& function, double first, double width) {
  std::vector<double> stops;
  const auto add = [&](double value) {
    const double entry = (value - first) / width;  // of absurd values no number
    if (entry >= 0 && entry <= TransferView::kEntries - 1) stops.push_back(entry);
  };
  for (const ColorPoint& point : function.colors) add(point.value);
  for (const OpacityPoint& point : function.opacities) add(point.value);
  std::sort(stops.begin(), stops.end());
  return stops;
}

}  // namespace

TransferView TransferTable::view() const {
  TransferView v;
  v.matter = matter.data();
  v.integral = integral.data();
  v.visible_before = visible_before.data();
  v.gradient_factor = gradient_factor.empty() ? nullptr : gradient_factor.data();
  v.entries = static_cast<int>(matter.size());
  v.integral_unit = integral_unit;
  v.integrals_per_unit = integral_unit > 0 ? 1 / integral_unit : 0;
  v.first_visible = first_visible;
  v.last_visible = last_visible;
  v.even = even;
  v.to_entry_scale = to_entry_scale;
  v.to_entry_offset = to_entry_offset;
  v.to_gradient_entry = to_gradient_entry;
  return v;
}

TransferTable bake(const TransferFunction& function, double scale, double offset, double most_extinction) {
  constexpr int kEntries = TransferView::kEntries;
  constexpr int kParts =
      4;  // of the way between two entries, so that a step between them is integrated right
  const double first = std::min(function.colors.front().value, function.opacities.front().value);
  double last = std::max(function.colors.back().value, function.opacities.back().value);
  if (!(last > first)) last = first + std::max(1.0, std::abs(first)) * 1e-6;
  const double width = (last - first) / (kEntries - 1);
  TransferTable table;
  table.to_entry_scale = static_cast<float>(scale / width);
  table.to_entry_offset = static_cast<float>((offset - first) / width);
  double greatest = 0;
  for (int i = 0; i < kEntries; ++i) {
    table.matter.push_back(matter_at(function, first + i * width, most_extinction));
    greatest = std::max(greatest, static_cast<double>(table.matter.back().extinction));
  }
  count_visible(table);
  // The whole integral stays below 2^31, so that differences have a sign.
  table.integral_unit = static_cast<float>(std::max(greatest, 1e-30) * kEntries / 0x1p31);
  std::array<double, 4> sum{};
  for (int i = 0; i < kEntries; ++i) {
    TransferView::Integral& integral = table.integral.emplace_back();
    for (std::size_t c = 0; c < 4; ++c) {
      integral.sum[c] = static_cast<std::uint32_t>(std::llround(sum[c] / double(table.integral_unit)));
    }
    std::array<double, 4> mean{};
    for (int k = 0; k < kParts; ++k) {
      const double value = first + (i + (k + 0.5) / kParts) * width;
      const Matter m = matter_at(function, value, most_extinction);
      const double parts[4] = {m.color.x, m.color.y, m.color.z, m.extinction};
      for (std::size_t c = 0; c < 4; ++c) mean[c] += std::min(parts[c], greatest) / kParts;
    }
    for (std::size_t c = 0; c < 4; ++c) {
      integral.density[c] = static_cast<float>(mean[c]);
      sum[c] += mean[c];
    }
  }
  find_even_means(stops_of(function, first, width), table);
  if (!function.gradients.empty()) {
    const double steepest = std::max(function.gradients.back().gradient, 1e-30);
    for (int i = 0; i < TransferView::kGradientEntries; ++i) {
      const double gradient = steepest * i / (TransferView::kGradientEntries - 1);
      table.gradient_factor.push_back(static_cast<float>(function.gradient_factor(gradient)));
    }
    table.to_gradient_entry =
        static_cast<float>(std::abs(scale) * (TransferView::kGradientEntries - 1) / steepest);
  }
  return table;
}

TransferTable bake_labels(const TransferFunction& function, double scale, double offset,
                          std::uint32_t labels) {
  TransferTable table;
  table.to_entry_scale = 1;
  for (std::uint32_t label = 0; label < std::max(labels, 2u); ++label) {
    table.matter.push_back(matter_at(function, scale * label + offset, kOpaqueLabel));
  }
  table.integral.resize(table.matter.size());
  count_visible(table);
  return table;
}

TransferTable bake_opacities() {
  TransferTable table;
  table.to_entry_scale = 1;
  table.matter.assign(256, Matter{{}, 1});
  table.matter[0] = {};
  table.integral.resize(table.matter.size());
  count_visible(table);
  return table;
}

}  // namespace gvx::scene
