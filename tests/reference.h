/// \file
/// The brute-force reference: every ray through the whole volume at full resolution, in double precision and
/// fine steps, with the transfer function itself instead of its table. It shares camera, function and shading
/// formula with the engine, and no code of traversal, sampling, skipping or caching.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <tuple>
#include <vector>

#include "gvx/core/affine.h"
#include "gvx/render/film.h"
#include "gvx/render/frame.h"

namespace gvx::tests {

/// A volume as the reference sees it: physical values at voxel centres, clamped at the faces.
struct ReferenceVolume {
  Vec3i dimensions;
  Affine3 voxel_to_world;  ///< voxel i covers [i, i+1]
  std::function<double(std::int64_t, std::int64_t, std::int64_t)> voxel;

  /// Trilinear between centres.
  double value(Vec3d p) const;
  /// Per voxel, by central differences of half a voxel.
  Vec3d gradient(Vec3d p) const;
};

struct ReferencePicture {
  render::Picture picture;
  /// Bricks of m^3 voxels that hold a sample which adds to the picture.
  std::set<std::tuple<std::int64_t, std::int64_t, std::int64_t>> necessary_bricks;
};

/// Renders with `samples_per_voxel` steps a voxel (of the smallest spacing), until 1/10000 is left to see.
/// `soft_gradient` is the engine's, in physical units a voxel. `m` is the brick size that necessary_bricks
/// counts in.
ReferencePicture render_reference(const ReferenceVolume& volume, const render::View& view,
                                  double samples_per_voxel, double soft_gradient, std::int64_t m = 16);

/// Peak signal-to-noise ratio of the colours, peak 1; infinite where they are equal.
double psnr(const render::Picture& a, const render::Picture& b);

}  // namespace gvx::tests
