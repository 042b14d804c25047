/// \file
/// Hypertexture: a density in the shell around a surface that a field of distances gives, with noise in it
/// (Perlin and Hoffert, SIGGRAPH 1989; section 6.3 and example 3 of the 2008 report).
#pragma once

#include <memory>
#include <vector>

#include "gvx/produce/density.h"
#include "gvx/produce/field.h"

namespace gvx::produce {

/// Densities from 0 (outside) to 1.
class HypertextureField final : public Field {
 public:
  /// `distance`: below 0 inside; where it is greater than reach() it need not be right.
  HypertextureField(std::shared_ptr<const Field> distance, const HypertextureOptions& options);

  /// Farther from the surface than this the density is 0 or 1, in voxels of this spacing.
  static double reach(const HypertextureOptions& options, double spacing);

  void sample(const VoxelBlock& block, std::span<float> values) const override;
  ValueRange bounds(const Box3d& box, double coarsest_spacing) const override;

 private:
  std::shared_ptr<const Field> distance_;
  HypertextureOptions options_;
};

/// A field that changes no faster than a distance, found at every second or fourth voxel where that is fine
/// enough, and mixed between (the report: "low-resolution bricks of the distance field"). Which ones depends
/// on where they are and not on the block: blocks agree where they meet.
class SparseField final : public Field {
 public:
  /// Found at least four times in `detail`.
  SparseField(std::shared_ptr<const Field> field, double detail)
      : field_(std::move(field)), detail_(detail) {}

  void sample(const VoxelBlock& block, std::span<float> values) const override;
  ValueRange bounds(const Box3d& box, double coarsest_spacing) const override;

 private:
  static constexpr std::uint32_t kMostStride = 4;
  std::uint32_t stride_at(double spacing) const;

  std::shared_ptr<const Field> field_;
  double detail_;
};

/// The distance to a union of balls, below 0 inside; inside of several no more than a bound of it.
class BallsField final : public Field {
 public:
  struct Ball {
    Vec3d centre;
    double radius = 0;
  };
  explicit BallsField(std::vector<Ball> balls) : balls_(std::move(balls)) {}

  void sample(const VoxelBlock& block, std::span<float> values) const override;
  ValueRange bounds(const Box3d& box, double coarsest_spacing) const override;

 private:
  double distance(Vec3d p) const;

  std::vector<Ball> balls_;
};

/// A heap of balls that swell upwards from a flat base: what a cumulus is made of.
std::vector<BallsField::Ball> cumulus_balls(std::uint32_t seed);

}  // namespace gvx::produce
