#include "gvx/scene/transfer_function.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "gvx/scene/even_means.h"
#include "gvx/scene/transfer_limits.h"

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

/// Behind those of the same place.
template <typename Point>
void insert(std::vector<Point>& points, const Point& point, double Point::*place) {
  const auto at = std::upper_bound(points.begin(), points.end(), point.*place,
                                   [&](double p, const Point& other) { return p < other.*place; });
  points.insert(at, point);
}

}  // namespace

TransferFunction& TransferFunction::add_color(double value, Vec3d color) {
  insert(colors, {value, color}, &ColorPoint::value);
  return *this;
}

TransferFunction& TransferFunction::add_opacity(double value, double opacity) {
  insert(opacities, {value, opacity}, &OpacityPoint::value);
  return *this;
}

TransferFunction& TransferFunction::add_gradient(double gradient, double factor) {
  insert(gradients, {gradient, factor}, &GradientPoint::gradient);
  return *this;
}

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

/// The physical values that a table is laid over.
struct TableSpan {
  double first, last;
  int entries = TransferView::kEntries;

  double width() const { return (last - first) / (entries - 1); }
};

/// The points of a curve that bend it: at either end all but the last of those that are alike say nothing.
template <typename Point, typename Member>
std::span<const Point> bends_of(const std::vector<Point>& points, Member member) {
  std::span<const Point> bends(points);
  while (bends.size() > 1 && bends[0].*member == bends[1].*member) bends = bends.subspan(1);
  while (bends.size() > 1 && bends[bends.size() - 2].*member == bends.back().*member) {
    bends = bends.first(bends.size() - 1);
  }
  return bends;
}

/// Beyond its ends the function goes on as it is there.
TableSpan between_bends(const TransferFunction& function) {
  const auto opacities = bends_of(function.opacities, &OpacityPoint::opacity);
  const auto colors = bends_of(function.colors, &ColorPoint::color);
  TableSpan span{opacities.front().value, opacities.back().value};
  if (opacities.size() == 1 && opacities[0].opacity == 0) return span;
  if (opacities.size() == 1) return {colors.front().value, colors.back().value};
  // A colour says nothing where nothing is seen.
  if (colors.size() == 1) return span;
  if (opacities.front().opacity > 0) span.first = std::min(span.first, colors.front().value);
  if (opacities.back().opacity > 0) span.last = std::max(span.last, colors.back().value);
  return span;
}

/// The part of `span` within these values; where there is none, the end of them that is nearest to it.
TableSpan held_to(TableSpan span, ValueSpan values) {
  if (!(values.minimum <= values.maximum)) return span;
  span.first = std::clamp(span.first, values.minimum, values.maximum);
  span.last = std::clamp(span.last, values.minimum, values.maximum);
  return span;
}

/// How many entries a table needs to follow a curve. `difference`: of two points, as a share of the greatest.
template <typename Point, typename Difference>
double entries_wanted(const std::vector<Point>& points, TableSpan span, const Difference& difference) {
  // The most change from an entry to the next, and the fewest entries from a point to the next.
  constexpr double kLeastStep = 1.0 / 32, kLeastApart = 2;
  double wanted = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double apart = points[i + 1].value - points[i].value;
    if (!(apart > 0) || points[i + 1].value <= span.first || points[i].value >= span.last) continue;
    const double steps = std::max(difference(points[i], points[i + 1]) / kLeastStep, kLeastApart);
    wanted = std::max(wanted, steps * (span.last - span.first) / apart);
  }
  return wanted;
}

double entries_wanted(const TransferFunction& function, TableSpan span) {
  double most = 0;
  for (const OpacityPoint& point : function.opacities) most = std::max(most, point.opacity);
  if (!(most > 0)) return 0;
  return std::max(entries_wanted(function.opacities, span,
                                 [&](const OpacityPoint& a, const OpacityPoint& b) {
                                   return std::abs(b.opacity - a.opacity) / most;
                                 }),
                  entries_wanted(function.colors, span, [](const ColorPoint& a, const ColorPoint& b) {
                    const Vec3d change = b.color - a.color;
                    return std::max({std::abs(change.x), std::abs(change.y), std::abs(change.z)});
                  }));
}

/// `outer`: as far as the function has points. `least_width`: that entries may have.
TableSpan table_span(const TransferFunction& function, TableSpan outer, ValueSpan values,
                     double least_width) {
  TableSpan span = outer;
  double wanted = entries_wanted(function, span);
  if (wanted > TransferView::kMostEntries) {
    span = held_to(between_bends(function), values);
    wanted = entries_wanted(function, span);
  }
  while (span.entries < wanted && span.entries < TransferView::kMostEntries) span.entries *= 2;
  // A single value gets its surroundings, so that a step there stays a step.
  if (!(span.last > span.first)) {
    // Wide enough that the farthest values still have finite entries.
    const double range = values.maximum - values.minimum;
    const double around = std::max(1e-6 * std::abs(span.first), 1e-20 * (std::isfinite(range) ? range : 1));
    span = {span.first - around, span.first + around};
  }
  span.last = std::max(span.last, span.first + least_width * (span.entries - 1));
  // A step at the lower end has something below it.
  const auto is_step = [&](const auto& points) {
    return points.size() > 1 && points[0].value == points[1].value && points[0].value == span.first;
  };
  if (values.minimum < span.first && (is_step(function.opacities) || is_step(function.colors))) {
    span.first -= span.width();
  }
  return span;
}

/// From its first point to its last, as far as there are such values.
TableSpan outer_span(const TransferFunction& function, ValueSpan values) {
  return held_to({std::min(function.colors.front().value, function.opacities.front().value),
                  std::max(function.colors.back().value, function.opacities.back().value)},
                 values);
}

/// Where a function's slopes may change, in entries of a table.
std::vector<double> stops_of(const TransferFunction& function, const TableSpan& span) {
  std::vector<double> stops;
  const auto add = [&](double value) {
    const double entry = (value - span.first) / span.width();  // NaN for absurd values
    if (entry >= 0 && entry <= span.entries - 1) stops.push_back(entry);
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
  v.length_per_entry = float(TransferView::kEntries) / static_cast<float>(matter.size());
  v.to_gradient_entry = to_gradient_entry;
  return v;
}

TransferTable bake(const TransferFunction& function, double scale, double offset, double most_extinction,
                   ValueSpan values) {
  constexpr int kParts =
      4;  // of the way between two entries, so that a step between them is integrated right
  const TableSpan outer = outer_span(function, values);
  // Floats hold no more than 10^38 entries a value.
  const TableSpan span = table_span(function, outer, values, 1e-38 * std::abs(scale));
  const int entries = span.entries;
  const double first = span.first, width = span.width();
  TransferTable table;
  table.to_entry_scale = static_cast<float>(scale / width);
  // Right in the middle, whatever rounding did to the scale.
  const double middle = (0.5 * (span.first + span.last) - offset) / scale;
  table.to_entry_offset = static_cast<float>(0.5 * (entries - 1) - middle * double(table.to_entry_scale));
  table.span = std::max(outer.last - outer.first, width) / std::abs(scale);
  double greatest = 0;
  for (int i = 0; i < entries; ++i) {
    table.matter.push_back(matter_at(function, first + i * width, most_extinction));
    greatest = std::max(greatest, static_cast<double>(table.matter.back().extinction));
  }
  count_visible(table);
  // The whole integral stays below 2^31, so that differences have a sign.
  table.integral_unit = static_cast<float>(std::max(greatest, 1e-30) * entries / 0x1p31);
  std::array<double, 4> sum{};
  for (int i = 0; i < entries; ++i) {
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
  find_even_means(stops_of(function, span), table);
  if (!function.gradients.empty()) {
    const auto bends = bends_of(function.gradients, &GradientPoint::factor);
    const double steepest = std::max(bends.back().gradient, 1e-30);
    for (int i = 0; i < TransferView::kGradientEntries; ++i) {
      const double gradient = steepest * i / (TransferView::kGradientEntries - 1);
      table.gradient_factor.push_back(static_cast<float>(function.gradient_factor(gradient)));
    }
    table.to_gradient_entry =
        static_cast<float>(std::abs(scale) * (TransferView::kGradientEntries - 1) / steepest);
  }
  return table;
}

std::optional<std::pair<double, double>> points_too_close(const TransferFunction& function,
                                                          ValueSpan values) {
  const TableSpan span = table_span(function, outer_span(function, values), values, 0);
  double closest = 2 * span.width();
  std::optional<std::pair<double, double>> found;
  const auto look_at = [&](const auto& points) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const double first = points[i].value, last = points[i + 1].value;
      if (!(last > first) || !(last - first < closest) || last <= span.first || first >= span.last) continue;
      closest = last - first;
      found = {first, last};
    }
  };
  look_at(function.opacities);
  look_at(function.colors);
  return found;
}

TransferTable bake_labels(const TransferFunction& function, double scale, double offset,
                          std::uint32_t labels) {
  TransferTable table;
  table.to_entry_scale = 1;
  for (std::uint32_t label = 0; label < std::max(labels, 2u); ++label) {
    table.matter.push_back(matter_at(function, scale * label + offset, kOpaqueLabel));
  }
  table.span = static_cast<double>(table.matter.size());
  table.integral.resize(table.matter.size());
  count_visible(table);
  return table;
}

TransferTable bake_opacities() {
  TransferTable table;
  table.to_entry_scale = 1;
  table.matter.assign(256, Matter{{}, 1});
  table.matter[0] = {};
  table.span = static_cast<double>(table.matter.size());
  table.integral.resize(table.matter.size());
  count_visible(table);
  return table;
}

}  // namespace gvx::scene
