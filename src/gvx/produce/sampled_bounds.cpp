#include "gvx/produce/sampled_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "gvx/core/noise.h"

namespace gvx::produce {
namespace {

constexpr std::uint32_t kMostSamples = 32;
// Of the whole cube: more take longer than a user waits.
constexpr double kMostOfAll = 512;
// How far the borders of bricks may reach beyond the cube: two voxels of the root's, which has eight at
// least.
constexpr double kBeyond = 1.0 / 4;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Where in cell i along an axis the sample is taken: within its middle half, so that neighbours are neither
/// close together nor far apart.
double place_in(std::uint32_t i, std::uint32_t x, std::uint32_t y, std::uint32_t z, int axis) {
  const std::uint32_t random = noise::gradient_at(x, y, z, static_cast<std::uint32_t>(axis) + 1);  // 0 to 15
  return i + 0.25 + (random + 0.5) / 32;
}

}  // namespace

Result<SampledBounds> SampledBounds::create(FunctionField::Values values,
                                            const SampledBoundsOptions& options) {
  if (!values) return Error{"sampled bounds: the function is empty; expected one to sample"};
  if (!(options.feature > 0) || !(options.margin >= 0)) {
    return Error{"sampled bounds: expected a feature above 0 and a margin of 0 or more"};
  }
  if (options.samples < 2 || options.samples > kMostSamples) {
    return Error{"sampled bounds: " + std::to_string(options.samples) + " samples; expected 2 to " +
                 std::to_string(kMostSamples)};
  }
  return SampledBounds(std::move(values), options);
}

SampledBounds::SampledBounds(FunctionField::Values values, const SampledBoundsOptions& options)
    : values_(std::move(values)), options_(options) {
  if (options_.all) {
    all_ = *options_.all;
  } else {
    const double cells =
        std::clamp(std::ceil(2 * (1 + 2 * kBeyond) / options_.feature), double(options_.samples), kMostOfAll);
    all_ = sample({Vec3d(-kBeyond), Vec3d(1 + kBeyond)}, static_cast<std::uint32_t>(cells),
                  {-kInfinity, kInfinity});
  }
}

ValueRange SampledBounds::operator()(const Box3d& box) const {
  const Vec3d size = box.maximum - box.minimum;
  const double wanted = std::ceil(2 * std::max({size.x, size.y, size.z}) / options_.feature);
  if (wanted > kMostSamples) return all_;
  const std::uint32_t cells = std::max(options_.samples, static_cast<std::uint32_t>(wanted));
  // A cell more on every side: all of the box lies between samples.
  const Vec3d cell = size / double(cells);
  return sample({box.minimum - cell, box.maximum + cell}, cells + 2, all_);
}

ValueRange SampledBounds::sample(const Box3d& box, std::uint32_t cells, ValueRange within) const {
  const Vec3d cell = (box.maximum - box.minimum) / double(cells);
  ValueRange range{kInfinity, -kInfinity};
  float widest[3] = {};
  // Of the cells of this z, as far as they are sampled; behind them of the z before.
  std::vector<float> plane(std::size_t{cells} * cells);
  const auto compare = [&](int axis, float value, float neighbour) {
    widest[axis] = std::max(widest[axis], std::fabs(value - neighbour));  // no data is not compared
  };
  for (std::uint32_t z = 0; z < cells; ++z) {
    for (std::uint32_t y = 0; y < cells; ++y) {
      for (std::uint32_t x = 0; x < cells; ++x) {
        const Vec3d at(place_in(x, x, y, z, 0), place_in(y, x, y, z, 1), place_in(z, x, y, z, 2));
        const float value = values_(box.minimum + at * cell);
        float* const here = &plane[std::size_t{y} * cells + x];
        if (x > 0) compare(0, value, here[-1]);
        if (y > 0) compare(1, value, *(here - cells));
        if (z > 0) compare(2, value, *here);
        *here = value;
        range.minimum = std::min(range.minimum, value);
        range.maximum = std::max(range.maximum, value);
      }
    }
  }
  const auto reach = static_cast<float>(options_.margin * (double(widest[0]) + widest[1] + widest[2]));
  // Never narrower than what was found, even where `within` was wrong.
  return {std::min(range.minimum, std::max(range.minimum - reach, within.minimum)),
          std::max(range.maximum, std::min(range.maximum + reach, within.maximum))};
}

}  // namespace gvx::produce
