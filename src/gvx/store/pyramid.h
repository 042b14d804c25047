/// \file
/// PyramidBuilder makes all levels of the tree out of a volume that is handed over slice by slice, in one
/// pass and in bounded memory, and puts them into a StoreWriter.
///
/// Each level keeps a window of its last m+2n slices. When a level has the slices of a layer of bricks and
/// the n behind it, the layer's bricks are cut out, compressed on all threads, and written; when it has n
/// slices that make one of the level above, that one is pushed there:
///
///     finest   z ->  [.....m+2n slices....]  -> bricks of one layer -> writer
///                          | one voxel of n^3 (downsample.h)
///     above          [.....m+2n slices....]  -> bricks of one layer -> writer
///                          | ...
///
/// A brick is cut out with the border that `info` says, 1 or 2: both are within the rim of n. Voxels beyond
/// the volume's faces repeat those at the face; means take only the voxels that exist. Of scalars each coarse
/// level also keeps the variance of what its voxels stand for.
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

/// Takes the slices of a volume of one voxel format. The bytes written do not depend on the number of
/// threads.
class PyramidBuilder {
 public:
  /// `info` says the shape, voxel type, codec and all that the header keeps; its ranges and histograms, and
  /// whether there is no_data, are found here.
  PyramidBuilder(const exec::Device& cpu, StoreWriter& writer, VolumeInfo info);
  ~PyramidBuilder();

  /// The memory that the build will take: about m+2n slices of the finest level, and as much again for the
  /// variances of u8 scalars.
  static std::uint64_t window_bytes(const VolumeInfo& info);

  /// The next slices, dimensions.x * dimensions.y voxels each, the numbers of a voxel side by side. Voxels of
  /// type f32 must be finite, or NaN for no data.
  Status push_slices(std::int64_t count, std::span<const std::byte> voxels);

  /// Checks that every slice has come, and finishes the writer.
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
