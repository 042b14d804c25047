/// \file
/// build_store: converts a volume file of another program into a .gvx store, in bounded memory. The file is
/// read once, or up to three times if all values must be known before they can be converted. Several numbers
/// per voxel become channels; or colours, if the file says that they are.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/core/voxel.h"
#include "gvx/exec/device.h"
#include "gvx/io/volume_reader.h"
#include "gvx/store/format.h"

namespace gvx::io {

struct StoreBuildOptions {
  std::uint32_t n = 2;   ///< children along an axis of a node: 2 or 3
  std::uint32_t m = 16;  ///< voxels along an axis of a brick: 8, 16 or 32
  store::Codec codec = store::Codec::zstd;
  /// The type of voxels. Default: for samples of 8 or 16 bits the narrowest type that keeps every value, for
  /// wider samples f32.
  std::optional<VoxelType> type;
  /// The physical values are labels, whole numbers from 0 to 65535; an error if one is not. Coarser levels
  /// take the most frequent label.
  bool labels = false;
  std::uint64_t memory_bytes = 1ull << 30;  ///< the most memory that the build may use
};

struct StoreBuildReport {
  std::uint64_t bytes_written = 0;
  /// Samples that are NaN or infinite. They become no data.
  std::uint64_t not_finite = 0;
  /// How many of these are infinite.
  std::uint64_t infinite = 0;
  /// The physical value that stands for no data. f32 voxels have none: they hold NaN.
  std::optional<double> no_data_value = {};
  /// Samples beyond the range of the voxels' type. They were clamped.
  std::uint64_t clamped = 0;
  /// Samples that f32 voxels do not hold exactly: integers wider than 24 bits, and doubles. `digits` is the
  /// number of decimal digits that all of them keep.
  std::uint64_t rounded = 0;
  int digits = 0;
  /// Files with more bytes than the volume has.
  std::vector<Surplus> surplus = {};

  /// Warnings about the samples, one line each. They name `path`.
  std::vector<std::string> warnings(const std::string& path, SampleType type) const;
};

/// Is called from one thread with the bytes of samples that are done, and their total.
using BuildProgress = std::function<void(std::uint64_t done, std::uint64_t all)>;

/// Reads all slices of `reader`, which must be at its first slice, and writes the store to `path`. A file at
/// `path` is replaced when the store is complete. After an error it is as it was.
Result<StoreBuildReport> build_store(const exec::Device& cpu, SliceReader& reader, const std::string& path,
                                     const StoreBuildOptions& options, const BuildProgress& progress);

}  // namespace gvx::io
