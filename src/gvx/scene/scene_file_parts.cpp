// SceneFile: parts laid over what the program would choose.

#include <algorithm>

#include "gvx/scene/scene_file.h"
#include "gvx/scene/scene_items.h"

namespace gvx::scene {

Result<TransferFunction> FunctionParts::over(TransferFunction base, const ValueStatistics& statistics) const {
  if (!colors.empty()) base.colors = colors;
  if (!opacities.empty()) base.opacities = opacities;
  base.unit_distance = unit_distance.value_or(base.unit_distance);
  if (!gradients.empty()) base.gradients = gradients;
  GVX_TRY(check(base));
  if (window) base = stretched(std::move(base), window->span());
  if (percentiles) {
    constexpr double kLeastWidth = 1e-3;  // of the values' range, where next to all voxels have one value
    const double first = statistics.percentile(percentiles->first / 100);
    const double last = statistics.percentile(percentiles->last / 100);
    base = stretched(std::move(base), {first, std::max(last, first + kLeastWidth * statistics.width())});
  }
  if (opacity) base = with_opacity_factor(std::move(base), *opacity);
  GVX_TRY(check(base));
  return base;
}

LightingParts::LightingParts(const Lighting& lighting)
    : enabled(lighting.enabled),
      ambient(widened(lighting.ambient)),
      diffuse(widened(lighting.diffuse)),
      specular(widened(lighting.specular)),
      shininess(widened(lighting.shininess)),
      lights(std::in_place, lighting.light,
             lighting.light + std::clamp(lighting.lights, 0, Lighting::kMostLights)) {}

Lighting LightingParts::over(const Lighting& base) const {
  Lighting lighting = base;
  const auto part = [](const std::optional<double>& value, float& target) {
    if (value) target = static_cast<float>(*value);
  };
  lighting.enabled = enabled.value_or(base.enabled);
  part(ambient, lighting.ambient);
  part(diffuse, lighting.diffuse);
  part(specular, lighting.specular);
  part(shininess, lighting.shininess);
  if (lights) {
    // Frame::make() refuses more by their number.
    lighting.lights = static_cast<int>(lights->size());
    std::copy_n(lights->begin(), std::min<std::size_t>(lights->size(), Lighting::kMostLights),
                lighting.light);
  }
  return lighting;
}

}  // namespace gvx::scene
