#include "gvx/scene/function_range.h"

#include <algorithm>

namespace gvx::scene {

TransferFunction stretched(TransferFunction function, ValueSpan span) {
  const double first = std::min(function.colors.front().value, function.opacities.front().value);
  const double last = std::max(function.colors.back().value, function.opacities.back().value);
  const auto moved = [&](double value) {
    const double share = last > first ? (value - first) / (last - first) : 0;
    return (1 - share) * span.minimum + share * span.maximum;
  };
  for (ColorPoint& point : function.colors) point.value = moved(point.value);
  for (OpacityPoint& point : function.opacities) point.value = moved(point.value);
  return function;
}

TransferFunction with_opacity_factor(TransferFunction function, double factor) {
  std::vector<OpacityPoint> points;
  for (const OpacityPoint& point : function.opacities) {
    const OpacityPoint scaled{point.value, factor * point.opacity};
    // Where a curve passes 1 it has a bend.
    if (!points.empty() && (points.back().opacity > 1) != (scaled.opacity > 1)) {
      const OpacityPoint before = points.back();
      const double share = (1 - before.opacity) / (scaled.opacity - before.opacity);
      points.push_back({before.value + share * (scaled.value - before.value), 1});
    }
    points.push_back(scaled);
  }
  for (OpacityPoint& point : points) point.opacity = std::min(point.opacity, 1.0);
  function.opacities = std::move(points);
  return function;
}

}  // namespace gvx::scene
