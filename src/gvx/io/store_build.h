/// \file
/// build_store: another program's volume file into a .gvx store, in bounded memory and one pass, or up to
/// three where the values must be known before they can be converted. Volumes of several numbers a voxel
/// become channels, or colours where their file says that they are.
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
  /// Of the voxels; if not given the narrowest that keeps every value of 8 or 16 bits, and f32 for the wider
  /// ones.
  std::optional<VoxelType> type;
  /// The numbers are labels: they keep their values, and coarser levels take the most frequent.
  bool labels = false;
  std::uint64_t memory_bytes = 1ull << 30;  ///< bound of what the build holds at once
};

struct StoreBuildReport {
  std::uint64_t bytes_written = 0;
  /// Samples that are NaN or infinite: no data.
  std::uint64_t not_finite = 0;
  /// Of them, infinite.
  std::uint64_t infinite = 0;
  /// The physical value that they were stored as; none where they are kept as NaN, in f32 voxels.
  std::optional<double> no_data_value = {};
  /// Samples that lay beyond what the voxels hold, and were held to it.
  std::uint64_t clamped = 0;
  /// Integers wider than 24 bits and doubles that f32 does not hold to the last digit, and the decimal digits
  /// that all of those keep.
  std::uint64_t rounded = 0;
  int digits = 0;
  /// Files that hold more than the volume.
  std::vector<Surplus> surplus = {};

  /// A line for each thing that a user should know of the samples, naming `path`.
  std::vector<std::string> warnings(const std::string& path, SampleType type) const;
};

/// Called with what is done of all the work, in bytes of samples, from one thread.
using BuildProgress = std::function<void(std::uint64_t done, std::uint64_t all)>;

/// Reads all slices of `reader`, which stands at its first, and writes the store to `path`, replacing what is
/// there. On failure, and until all is written, `path` is as it was.
Result<StoreBuildReport> build_store(const exec::Device& cpu, SliceReader& reader, const std::string& path,
                                     const StoreBuildOptions& options, const BuildProgress& progress);

}  // namespace gvx::io
