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
#include "gvx/core/voxel.h"
#include "gvx/render/frame/film.h"
#include "gvx/render/frame/view.h"

namespace gvx::tests {

/// A volume as the reference sees it: physical values at voxel centres, clamped at the faces.
struct ReferenceVolume {
  Vec3i dimensions;
  Affine3 voxel_to_world;  ///< voxel i covers [i, i+1]
  std::function<double(std::int64_t, std::int64_t, std::int64_t)> voxel;
  /// Of its further planes, in the same way.
  std::vector<std::function<double(std::int64_t, std::int64_t, std::int64_t)>> more_planes = {};
  VoxelContent content = VoxelContent::scalar;

  std::size_t planes() const { return 1 + more_planes.size(); }
  double voxel_of(std::size_t plane, std::int64_t x, std::int64_t y, std::int64_t z) const {
    return plane == 0 ? voxel(x, y, z) : more_planes[plane - 1](x, y, z);
  }
  /// Trilinear between centres, of what `read` makes of the voxels' numbers.
  double interpolate(Vec3d p,
                     const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& read) const;
  double value(std::size_t plane, Vec3d p) const;
  /// Per voxel, of the cubic B-spline whose coefficients are the voxels.
  Vec3d gradient(std::size_t plane, Vec3d p) const;
  /// The same of 1 in voxels of this label and 0 in others.
  Vec3d region_gradient(double label, Vec3d p) const;
  /// The number of the voxel that the position is in.
  double nearest(Vec3d p) const;
};

struct ReferencePicture {
  render::Picture picture;
  /// Bricks of m^3 voxels that hold a sample which adds to the picture.
  std::set<std::tuple<std::int64_t, std::int64_t, std::int64_t>> necessary_bricks;
};

/// Renders with `samples_per_voxel` steps a voxel (of the smallest spacing), until 1/10000 is left to see.
/// `m` is the brick size that necessary_bricks counts in.
ReferencePicture render_reference(const ReferenceVolume& volume, const render::View& view,
                                  double samples_per_voxel, std::int64_t m = 16);

}  // namespace gvx::tests
