/// \file
/// TerrainField: ground without end in detail, the height of which is noise that changes with the height,
/// too: so there are overhangs.
#pragma once

#include "gvx/core/noise.h"
#include "gvx/produce/field.h"

namespace gvx::produce {

struct TerrainOptions {
  double sea = 0.3;      ///< the height without any noise, of the cube's
  double relief = 0.14;  ///< by how much a first octave of 1 lifts it
  double stretch = 0.5;  ///< how much of the noise's change across is its change with height
  FractalNoise noise{.octaves = 14, .wavelength = 0.45, .seed = 11};
};

/// The share of ground, 0 to 1.
class TerrainField final : public Field {
 public:
  explicit TerrainField(const TerrainOptions& options) : options_(options) {}

  void sample(const VoxelBlock& block, std::span<float> values) const override;
  ValueRange bounds(const Box3d& box, double coarsest_spacing) const override;

 private:
  Vec3d in_noise(Vec3d p) const { return {p.x, p.y, options_.stretch * p.z}; }

  TerrainOptions options_;
};

}  // namespace gvx::produce
