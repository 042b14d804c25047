/// \file
/// DicomReader: the slices of a DICOM stack, as they are stored or on an even, upright grid.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/dicom_geometry.h"
#include "gvx/io/dicom_pixels.h"
#include "gvx/io/volume_reader.h"

namespace gvx::io {

/// The slices of one frame in order, and the images that they are of.
struct DicomVolume {
  std::vector<DicomImage> images;
  std::vector<DicomSlice> slices;
  DicomGeometry geometry;

  const DicomImage& image(std::size_t slice) const { return images[slices[slice].image]; }
  const DicomFrame& frame(std::size_t slice) const { return image(slice).frames[slices[slice].frame]; }
  /// Have all slices the same slope and intercept?
  bool one_scale() const;
};

/// Hands out slices as they are. Where their slopes or intercepts differ, the samples are the physical
/// values: f32, or f64 where they are stored in 32 bits.
class DicomReader final : public SliceReader {
 public:
  /// Fills in what the volume says of `description`.
  DicomReader(DicomVolume volume, VolumeDescription description);

  const VolumeDescription& description() const override { return description_; }
  Status read_slices(std::int64_t count, std::span<std::byte> out) override;
  std::int64_t next_slice() const override { return next_slice_; }
  Status rewind() override;
  bool can_rewind() const override { return true; }

 private:
  DicomVolume volume_;
  VolumeDescription description_;
  DicomPixels pixels_;
  std::vector<std::byte> stored_;
  bool rescaled_ = false;
  std::int64_t next_slice_ = 0;
};

/// Hands out slices at even steps straight above each other: linear between slices along their normal, and
/// within slices where they are shifted. Samples are physical values (f32, NaN beside a tilted stack), or
/// colours (black beside it). Holds two slices of the stack.
class EvenDicomReader final : public SliceReader {
 public:
  /// An error where the grid would have more than 65536 voxels along an axis.
  static Result<std::unique_ptr<SliceReader>> create(DicomVolume volume, VolumeDescription description);

  const VolumeDescription& description() const override { return description_; }
  Status read_slices(std::int64_t count, std::span<std::byte> out) override;
  std::int64_t next_slice() const override { return next_slice_; }
  Status rewind() override;
  bool can_rewind() const override { return true; }

 private:
  struct Loaded {
    std::int64_t slice = -1;
    std::vector<float> values;
  };

  EvenDicomReader(DicomVolume volume, VolumeDescription description)
      : volume_(std::move(volume)), description_(std::move(description)) {}
  Result<const Loaded*> load(std::size_t slice);
  Status add_slice(std::size_t slice, float weight);
  Status resample(std::int64_t z);
  void hand_out(std::byte* out) const;

  DicomVolume volume_;
  VolumeDescription description_;
  DicomPixels pixels_;
  std::array<Loaded, 2> loaded_;
  std::vector<std::byte> stored_;
  std::vector<float> sum_, weight_;  // of the slice that is made, weighted
  double first_x_ = 0, first_y_ = 0, step_ = 0;
  std::int64_t next_slice_ = 0;
};

}  // namespace gvx::io
