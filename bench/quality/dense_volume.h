/// \file
/// DenseVolume: the finest level of a store as one array of floats, with its value ranges by blocks, so that
/// pictures can be made of it without any of the engine's trees, caches and samplers.
///
///     voxels: (x + 2*kRim) * (y + 2*kRim) * (z + 2*kRim) physical values, x fastest; the rim repeats the
///     faces
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/core/ray.h"
#include "gvx/core/result.h"
#include "gvx/core/voxel.h"

namespace gvx::bench {

class DenseVolume {
 public:
  static constexpr std::int64_t kRim = 2;
  /// Voxels along an edge of a block.
  static constexpr std::int64_t kBlock = 8;

  /// Reads every brick of the finest level of a store of one scalar channel.
  static Result<DenseVolume> load(const std::string& store_path);

  Vec3i dimensions() const { return dimensions_; }
  const Affine3& voxel_to_world() const { return voxel_to_world_; }
  Box3d extent() const { return {{0, 0, 0}, Vec3d(dimensions_)}; }
  bool anatomical() const { return anatomical_; }
  /// The smallest distance of two voxels, in the world.
  double spacing() const;

  /// Where a point is between the eight voxels around it.
  struct Place {
    const float* low;
    float weight[3];
  };
  /// Voxel i covers [i, i+1]; p lies in the volume, or on its faces.
  Place place(Vec3d p) const {
    const double x = p.x + (kRim - 0.5), y = p.y + (kRim - 0.5), z = p.z + (kRim - 0.5);
    const auto i = static_cast<std::int64_t>(x), j = static_cast<std::int64_t>(y),
               k = static_cast<std::int64_t>(z);
    return {&voxels_[static_cast<std::size_t>(i + stride_[1] * j + stride_[2] * k)],
            {static_cast<float>(x - static_cast<double>(i)), static_cast<float>(y - static_cast<double>(j)),
             static_cast<float>(z - static_cast<double>(k))}};
  }

  /// Trilinear between voxel centres.
  float value(const Place& p) const {
    return mix(bilinear(p.low, 0, 1, p), bilinear(p.low + stride_[2], 0, 1, p), p.weight[2]);
  }

  /// Per voxel, of the cubic B-spline whose coefficients are the voxels.
  Vec3f gradient(const Place& p) const {
    const Spline x(p.weight[0]), y(p.weight[1]), z(p.weight[2]);
    Vec3f sum;
    for (int k = 0; k < 4; ++k) {
      for (int j = 0; j < 4; ++j) {
        const float* row = p.low - 1 + (j - 1) * stride_[1] + (k - 1) * stride_[2];
        float value = 0, slope = 0;
        for (int i = 0; i < 4; ++i) value += x.value[i] * row[i], slope += x.slope[i] * row[i];
        sum = sum + Vec3f(z.value[k] * y.value[j] * slope, z.value[k] * y.slope[j] * value,
                          z.slope[k] * y.value[j] * value);
      }
    }
    return sum;
  }

  Vec3i blocks() const { return blocks_; }
  std::size_t block_index(Vec3i b) const {
    return static_cast<std::size_t>(b.x + blocks_.x * (b.y + blocks_.y * b.z));
  }
  /// Holds every value() of the block.
  ValueRange block_range(std::size_t index) const { return ranges_[index]; }

 private:
  void find_ranges();
  float& at(std::int64_t x, std::int64_t y, std::int64_t z) {
    return voxels_[static_cast<std::size_t>(x + kRim + stride_[1] * (y + kRim) + stride_[2] * (z + kRim))];
  }
  /// What four voxels along an axis weigh, at a place from 0 to 1 between the middle ones.
  struct Spline {
    float value[4], slope[4];

    explicit Spline(float t) {
      for (int i = 0; i < 4; ++i) {
        const float x = t + 1 - static_cast<float>(i), u = std::fabs(x);
        value[i] = u < 1 ? 2.0f / 3 - u * u + u * u * u / 2 : (2 - u) * (2 - u) * (2 - u) / 6;
        slope[i] = std::copysign(u < 1 ? 2 * u - 1.5f * u * u : (2 - u) * (2 - u) / 2, -x);
      }
    }
  };
  static float mix(float low, float high, float share) { return low + share * (high - low); }
  float bilinear(const float* low, int a, int b, const Place& p) const {
    const std::int64_t u = stride_[a], v = stride_[b];
    return mix(mix(low[0], low[u], p.weight[a]), mix(low[v], low[u + v], p.weight[a]), p.weight[b]);
  }
  Vec3i dimensions_;
  Affine3 voxel_to_world_;
  bool anatomical_ = false;
  std::int64_t stride_[3] = {1, 0, 0};
  std::vector<float> voxels_;
  Vec3i blocks_;
  std::vector<ValueRange> ranges_;
};

}  // namespace gvx::bench
