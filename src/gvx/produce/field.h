/// \file
/// Field: a scalar that has a value at every point, such as a density or the distance to a surface. Fields
/// can be built on other fields (produce/hypertexture.h). FieldProducer makes bricks of a field.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "gvx/core/ray.h"
#include "gvx/core/vec.h"
#include "gvx/core/voxel.h"

namespace gvx::produce {

/// A cube of cubic voxels in tree space. The centre of voxel (x, y, z) is first + spacing * (x, y, z).
struct VoxelBlock {
  Vec3d first;
  double spacing = 1;
  std::uint32_t edge = 1;  ///< voxels along each axis

  std::size_t voxels() const { return std::size_t(edge) * edge * edge; }
  Vec3d centre(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return first + spacing * Vec3d(x, y, z);
  }
};

/// A scalar field in tree space, the cube [0, 1]^3. All functions are called from several threads at once.
class Field {
 public:
  virtual ~Field() = default;

  /// The values of a block's voxels, x fastest. Detail finer than these voxels should be left out.
  virtual void sample(const VoxelBlock& block, std::span<float> values) const = 0;

  /// The oracle: bounds every value that sample() returns in the box, for voxels of `coarsest_spacing` or any
  /// finer spacing.
  virtual ValueRange bounds(const Box3d& box, double coarsest_spacing) const = 0;
};

/// Calls function(centre of the row's first voxel, values of the row) for each row of a block along x.
template <typename Function>
void for_each_row(const VoxelBlock& block, std::span<float> values, Function function) {
  std::size_t i = 0;
  for (std::uint32_t z = 0; z < block.edge; ++z) {
    for (std::uint32_t y = 0; y < block.edge; ++y, i += block.edge) {
      function(block.centre(0, y, z), values.subspan(i, block.edge));
    }
  }
}

/// Sets values[i] = function(centre) for all voxels of a block.
template <typename Function>
void sample_each(const VoxelBlock& block, std::span<float> values, Function function) {
  std::size_t i = 0;
  for (std::uint32_t z = 0; z < block.edge; ++z) {
    for (std::uint32_t y = 0; y < block.edge; ++y) {
      for (std::uint32_t x = 0; x < block.edge; ++x) values[i++] = function(block.centre(x, y, z));
    }
  }
}

/// A field that is given as two functions.
class FunctionField final : public Field {
 public:
  using Values = std::function<float(Vec3d)>;
  /// Bounds that hold every value in the box.
  using Bounds = std::function<ValueRange(const Box3d&)>;

  FunctionField(Values values, Bounds bounds) : values_(std::move(values)), bounds_(std::move(bounds)) {}

  void sample(const VoxelBlock& block, std::span<float> values) const override {
    sample_each(block, values, values_);
  }
  ValueRange bounds(const Box3d& box, double) const override { return bounds_(box); }

 private:
  Values values_;
  Bounds bounds_;
};

}  // namespace gvx::produce
