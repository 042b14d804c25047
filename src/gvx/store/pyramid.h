/// \file
/// PyramidBuilder: writes a volume into a store at all levels, its resolutions from the finest to the
/// coarsest. It takes the volume slice by slice, in one pass and in bounded memory.
///
/// A brick has m voxels along each axis. A coarse voxel stands for n finer ones along each axis. Each level
/// keeps its last m+2n slices. When these hold a layer of bricks and the n slices behind it, the bricks of
/// the layer are cut out, compressed on all threads, and written. Each n slices are averaged to one slice,
/// which goes to the next coarser level:
///
///     finest   z ->  [.....m+2n slices....]  -> bricks of one layer -> writer
///                          | one voxel of n^3 (downsample.h)
///     above          [.....m+2n slices....]  -> bricks of one layer -> writer
///                          | ...
///
/// A brick has the border that `info` names, 1 or 2. Voxels beyond the volume's faces repeat those at the
/// face. Means count only the voxels that exist. For scalars, each coarse level also keeps the variance of
/// the finest voxels that a voxel stands for.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/exec/device.h"
#include "gvx/store/format.h"
#include "gvx/store/store_writer.h"

namespace gvx::store {

/// Takes the slices of a volume. The bytes of the store do not depend on the number of threads.
class PyramidBuilder {
 public:
  /// `info` has the shape, the type of voxels, the codec, and all else that the header holds. Ranges,
  /// histograms and no_data are computed here.
  PyramidBuilder(const exec::Device& cpu, StoreWriter& writer, VolumeInfo info);
  ~PyramidBuilder();

  /// The memory that the build needs: about m+2n slices of the finest level, and for u8 scalars as much again
  /// for variances.
  static std::uint64_t window_bytes(const VolumeInfo& info);

  /// Takes the next slices, of dimensions.x * dimensions.y voxels each. The numbers of a voxel are side by
  /// side. Voxels of type f32 must be finite, or NaN for no data.
  Status push_slices(std::int64_t count, std::span<const std::byte> voxels);

  /// Finishes the store. An error if slices are missing.
  Status finish();

 private:
  template <typename Voxel>
  struct Levels;

  struct Steps {
    virtual ~Steps() = default;
    virtual Status push(std::int64_t count, std::span<const std::byte> voxels) = 0;
    virtual Status finish() = 0;
  };

  std::unique_ptr<Steps> steps_;
};

}  // namespace gvx::store
