/// \file
/// open_volume: opens a volume file of another program. The format is known by the file's name. VolumeReader:
/// reads it slice by slice, in native byte order. Samples go directly to the caller's memory, so volumes may
/// be larger than memory.
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

/// Bytes of a file behind its last sample.
struct Surplus {
  std::string path;
  std::uint64_t bytes = 0;
  bool counted = true;  ///< if not, there are more
};

/// A volume that is read slice by slice. A slice has all voxels of one z.
class SliceReader {
 public:
  virtual ~SliceReader() = default;

  virtual const VolumeDescription& description() const = 0;

  /// Reads the next `count` slices into `out`, x fastest, in native byte order. `out` has count*slice_bytes
  /// bytes. An error if that many slices are not left, or if the data end early or are damaged. After an
  /// error, call rewind() before reading on.
  virtual Status read_slices(std::int64_t count, std::span<std::byte> out) = 0;

  /// The number of the slice that read_slices() reads next.
  virtual std::int64_t next_slice() const = 0;

  /// Goes back to slice 0. An error for pipes.
  virtual Status rewind() = 0;
  virtual bool can_rewind() const = 0;

  /// The files that hold more bytes than the volume, apart from a line end. Call it after the last slice. In
  /// a pipe or a compressed file, at most one MiB is counted.
  virtual std::vector<Surplus> surplus() { return {}; }
};

/// Reads the z-slices of one volume in order.
class VolumeReader final : public SliceReader {
 public:
  /// An error if check_description() finds one, or if a data file is missing, too short, or longer than
  /// exact_size allows. The length of compressed data is known only when they are read.
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

/// Opens a volume file: .nrrd, .nhdr, .nii, .hdr/.img, .mha, .mhd, DICOM (a file or a folder), or raw
/// samples. NIfTI may end in .gz. Raw samples are .raw, .bin or .dat, also with .gz or .bz2; any other name
/// if `options.raw` gives the dimensions; and "-" for standard input. The spacing in `options.raw` replaces
/// that of any format. Its other options are an error for files with a header, and so are options that the
/// format does not have.
Result<std::unique_ptr<SliceReader>> open_volume(const std::string& path, const VolumeOptions& options);

/// The files that open_volume() would read, according to the header. If the header cannot be read: only
/// `path`.
std::vector<std::string> volume_files(const std::string& path, const VolumeOptions& options);

}  // namespace gvx::io
