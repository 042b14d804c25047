/// \file
/// VolumeReader: other people's volumes, slice by slice, in native byte order; and open_volume, which knows
/// the formats by their names. Memory is bounded whatever the volume's size: samples go straight to the
/// caller.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/byte_stream.h"
#include "gvx/io/volume_file.h"
#include "gvx/io/volume_options.h"

namespace gvx::io {

/// What a file holds behind its last sample.
struct Surplus {
  std::string path;
  std::uint64_t bytes = 0;
  bool counted = true;  ///< otherwise there are more
};

/// A volume that is read slice by slice.
class SliceReader {
 public:
  virtual ~SliceReader() = default;

  virtual const VolumeDescription& description() const = 0;

  /// Writes the next `count` slices, x fastest, in native byte order. `out` holds exactly count*slice_bytes
  /// bytes, and as many slices must be left. An error where the data end early or are broken; after one, only
  /// rewind() helps.
  virtual Status read_slices(std::int64_t count, std::span<std::byte> out) = 0;

  /// The slice that read_slices() reads next.
  virtual std::int64_t next_slice() const = 0;

  /// Goes back to slice 0; an error for pipes.
  virtual Status rewind() = 0;
  virtual bool can_rewind() const = 0;

  /// To be called after the last slice: the files that hold more than the volume, and more than a line end.
  /// No more than the first MiB of a pipe or packed file is counted.
  virtual std::vector<Surplus> surplus() { return {}; }
};

/// Reads the z-slices of one volume in order.
class VolumeReader final : public SliceReader {
 public:
  /// Fails where check_description() does, a data file is not there, or its size shows that it is too short
  /// (or longer than exact_size allows); of packed data that shows only while reading.
  static Result<std::unique_ptr<VolumeReader>> open(VolumeFile file);

  const VolumeDescription& description() const override { return file_.description; }
  Status read_slices(std::int64_t count, std::span<std::byte> out) override;
  std::int64_t next_slice() const override { return next_slice_; }
  Status rewind() override;
  bool can_rewind() const override { return stream_->can_rewind(); }
  std::vector<Surplus> surplus() override;

 private:
  explicit VolumeReader(VolumeFile file) : file_(std::move(file)) {}
  std::uint64_t share_bytes() const;
  std::uint64_t least_file_bytes() const;
  Status check_other_files() const;
  Status open_data_file(std::size_t index);
  Status find_first_sample();
  Status check_size() const;
  Status skip_to_first_sample();
  Status read_samples(std::span<std::byte> out);
  Error data_end_early(std::uint64_t bytes_there) const;

  VolumeFile file_;
  std::size_t data_file_ = 0;  // that stream_ reads
  std::unique_ptr<ByteStream> stream_;
  std::uint64_t first_sample_ = 0;  // decoded bytes before it
  std::uint64_t share_left_ = 0;    // bytes of the data file's samples that were not read yet
  std::int64_t next_slice_ = 0;
  std::vector<std::byte> behind_;  // decoded bytes that were read behind the last sample
};

/// Opens .nrrd, .nhdr, .nii, .hdr/.img, .mha and .mhd (NIfTI also with .gz), and raw samples: .raw, .bin and
/// .dat (also with .gz or .bz2), any other name when `options.raw` gives the dimensions, and "-" for standard
/// input. The spacing in `options.raw` replaces that of any format; its other options are an error for files
/// that describe themselves, as are options that the format does not take.
Result<std::unique_ptr<SliceReader>> open_volume(const std::string& path, const VolumeOptions& options);

/// The files that open_volume() would read, as far as the header says; `path` alone where it cannot be read.
std::vector<std::string> volume_files(const std::string& path, const VolumeOptions& options);

}  // namespace gvx::io
