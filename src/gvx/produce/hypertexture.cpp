#include "gvx/produce/hypertexture.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "gvx/produce/coverage.h"

namespace gvx::produce {
HypertextureField::HypertextureField(std::shared_ptr<const Field> distance,
                                     const HypertextureOptions& options)
    : distance_(std::move(distance)), options_(options) {}

double HypertextureField::reach(const HypertextureOptions& options, double spacing) {
  return coverage_width(options.thickness, spacing) +
         options.strength * options.thickness * options.noise.most();
}

void HypertextureField::sample(const VoxelBlock& block, std::span<float> values) const {
  distance_->sample(block, values);
  const double width = coverage_width(options_.shell(), block.spacing), strength = options_.shift();
  const bool solid = options_.kind == HypertextureKind::solid_noise;
  thread_local std::vector<double> noise;
  noise.resize(block.edge);
  for_each_row(block, values, [&](Vec3d first, std::span<float> row) {
    const auto add_noise = [&](auto settled) {
      options_.noise.row(first, block.spacing, block.edge, block.spacing, noise.data(),
                         [&](const double* so_far, double rest) {
                           for (std::size_t i = 0; i < row.size(); ++i) {
                             if (!settled(double(row[i]), so_far[i], rest)) return false;
                           }
                           return true;
                         });
    };
    if (strength > 0) {
      add_noise([&](double d, double sum, double rest) {
        return coverage_settled(d + strength * sum, strength * rest, width);
      });
    } else if (solid) {
      add_noise([&](double d, double, double) { return coverage(d, width) == 0; });
    }
    for (std::size_t i = 0; i < row.size(); ++i) {
      const double here = strength > 0 || solid ? noise[i] : 0;
      row[i] = static_cast<float>(density_at(options_, double(row[i]), here, block.spacing));
    }
  });
}

ValueRange HypertextureField::bounds(const Box3d& box, double coarsest_spacing) const {
  return density_bounds(options_, distance_->bounds(box, coarsest_spacing), box, coarsest_spacing);
}

std::uint32_t SparseField::stride_at(double spacing) const {
  std::uint32_t stride = kMostStride;
  while (stride > 1 && 4 * stride * spacing > detail_) stride /= 2;
  return stride;
}

void SparseField::sample(const VoxelBlock& block, std::span<float> values) const {
  const auto stride = static_cast<std::int64_t>(stride_at(block.spacing));
  if (stride == 1) return field_->sample(block, values);
  // The block's first voxel and the first that is found, counted from the cube's corner.
  std::int64_t begin[3], low[3];
  std::int64_t most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    begin[axis] = std::llround(block.first[axis] / block.spacing - 0.5);
    low[axis] = (begin[axis] + (begin[axis] < 0 ? 1 - stride : 0)) / stride * stride;
    most = std::max(most, begin[axis] + block.edge - 1 - low[axis]);
  }
  const auto edge = static_cast<std::uint32_t>((most + stride - 1) / stride + 1);
  const auto centre = [&](int axis) { return (static_cast<double>(low[axis]) + 0.5) * block.spacing; };
  const VoxelBlock sparse{
      {centre(0), centre(1), centre(2)}, static_cast<double>(stride) * block.spacing, edge};
  std::vector<float> found(sparse.voxels());
  field_->sample(sparse, found);
  const auto at = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return found[static_cast<std::size_t>((z * edge + y) * edge + x)];
  };
  const auto mix = [](float a, float b, float share) { return a + share * (b - a); };
  std::size_t i = 0;
  for (std::int64_t z = begin[2] - low[2], k = 0; k < block.edge; ++k, ++z) {
    for (std::int64_t y = begin[1] - low[1], j = 0; j < block.edge; ++j, ++y) {
      for (std::int64_t x = begin[0] - low[0], h = 0; h < block.edge; ++h, ++x) {
        const auto cell = [&](std::int64_t v) { return std::min<std::int64_t>(v / stride, edge - 2); };
        const std::int64_t cx = cell(x), cy = cell(y), cz = cell(z);
        const auto share = [&](std::int64_t v, std::int64_t c) {
          return static_cast<float>(v - c * stride) / static_cast<float>(stride);
        };
        const float u = share(x, cx), v = share(y, cy), w = share(z, cz);
        const float front = mix(mix(at(cx, cy, cz), at(cx + 1, cy, cz), u),
                                mix(at(cx, cy + 1, cz), at(cx + 1, cy + 1, cz), u), v);
        const float back = mix(mix(at(cx, cy, cz + 1), at(cx + 1, cy, cz + 1), u),
                               mix(at(cx, cy + 1, cz + 1), at(cx + 1, cy + 1, cz + 1), u), v);
        values[i++] = mix(front, back, w);
      }
    }
  }
}

ValueRange SparseField::bounds(const Box3d& box, double coarsest_spacing) const {
  ValueRange range = field_->bounds(box, coarsest_spacing);
  // As far as what is mixed is away, and rounding.
  const double away = std::sqrt(3.0) * kMostStride * std::min(coarsest_spacing, detail_) + 1e-6;
  range.minimum -= static_cast<float>(away);
  range.maximum += static_cast<float>(away);
  return range;
}

double BallsField::distance(Vec3d p) const {
  double least = INFINITY;
  for (const Ball& ball : balls_) least = std::min(least, length(p - ball.centre) - ball.radius);
  return least;
}

void BallsField::sample(const VoxelBlock& block, std::span<float> values) const {
  // Only balls that are the nearest somewhere in the block.
  const double half = 0.5 * block.spacing * (block.edge - 1), radius = std::sqrt(3.0) * half + 1e-9;
  const Vec3d middle = block.first + Vec3d(half);
  const double least = distance(middle);
  BallsField near({});
  for (const Ball& ball : balls_) {
    if (length(middle - ball.centre) - ball.radius <= least + 2 * radius) near.balls_.push_back(ball);
  }
  sample_each(block, values, [&](Vec3d p) { return static_cast<float>(near.distance(p)); });
}

ValueRange BallsField::bounds(const Box3d& box, double) const {
  const double at = distance(0.5 * (box.minimum + box.maximum));
  const double radius = 0.5 * length(box.maximum - box.minimum) + 1e-6;
  return {static_cast<float>(at - radius), static_cast<float>(at + radius)};
}

std::vector<BallsField::Ball> cumulus_balls(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 8) / static_cast<double>(1u << 24);
  };
  std::vector<BallsField::Ball> balls;
  // Three storeys, each of fewer and smaller balls, nearer to the middle.
  constexpr int kBalls[] = {13, 9, 5};
  for (int storey = 0; storey < 3; ++storey) {
    for (int i = 0; i < kBalls[storey]; ++i) {
      const double turn = 2 * M_PI * (i + between(0, 0.8)) / kBalls[storey];
      const double away = between(0.25, 1) * (0.27 - 0.075 * storey);
      const double radius = between(0.085, 0.13) - 0.008 * storey;
      balls.push_back({{0.5 + away * std::cos(turn), 0.5 + 0.8 * away * std::sin(turn),
                        0.30 + 0.13 * storey + between(-0.02, 0.03)},
                       radius});
    }
  }
  return balls;
}

}  // namespace gvx::produce
