/// \file
/// TerrainField: ground without end in detail, the height of which is noise that changes with the height,
/// too: so there are overhangs.
#pragma once

#include "gvx/core/noise.h"
#include "gvx/produce/coverage.h"
#include "gvx/produce/field.h"

namespace gvx::produce {

struct TerrainOptions {
  double sea = 0.3;      ///< the height without any noise, of the cube's
  double relief = 0.14;  ///< by how much a first octave of 1 lifts it
  double stretch = 0.5;  ///< how much of the noise's change across is its change with height
  FractalNoise noise{.octaves = 14, .wavelength = 0.45, .seed = 11};

  GVX_HD Vec3d in_noise(Vec3d p) const { return {p.x, p.y, stretch * p.z}; }
  /// By how much a height is above ground that noise lifts.
  GVX_HD double above(double height, double lift) const { return height - sea - relief * lift; }
  /// The share of ground in a voxel.
  GVX_HD double ground(Vec3d p, double lift, double spacing) const {
    return coverage(above(p.z, lift), coverage_width(0, spacing));
  }
  /// Field::bounds
  GVX_HD ValueRange bounds(const Box3d& box, double coarsest_spacing) const {
    constexpr double kMargin = 1e-12;
    const noise::Interval n = noise.bounds({in_noise(box.minimum), in_noise(box.maximum)}, coarsest_spacing);
    const noise::Interval height{above(box.minimum.z, n.high) - kMargin,
                                 above(box.maximum.z, n.low) + kMargin};
    const noise::Interval c = coverage_bounds(height, 0, coverage_width(0, coarsest_spacing));
    return {static_cast<float>(c.low), static_cast<float>(c.high)};
  }
};

/// The share of ground, 0 to 1.
class TerrainField final : public Field {
 public:
  explicit TerrainField(const TerrainOptions& options) : options_(options) {}

  void sample(const VoxelBlock& block, std::span<float> values) const override;
  ValueRange bounds(const Box3d& box, double coarsest_spacing) const override {
    return options_.bounds(box, coarsest_spacing);
  }

 private:
  TerrainOptions options_;
};

}  // namespace gvx::produce
