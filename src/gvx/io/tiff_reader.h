/// \file
/// TiffReader: the slices of a TiffVolume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/tiff_volume.h"
#include "gvx/io/volume_reader.h"

namespace gvx::io {

class TiffReader final : public SliceReader {
 public:
  /// Fails where check_description() does.
  static Result<std::unique_ptr<TiffReader>> open(TiffVolume volume);

  const VolumeDescription& description() const override { return volume_.description; }
  Status read_slices(std::int64_t count, std::span<std::byte> out) override;
  std::int64_t next_slice() const override { return next_slice_; }
  Status rewind() override;
  bool can_rewind() const override { return true; }

 private:
  explicit TiffReader(TiffVolume volume) : volume_(std::move(volume)) {}
  Status read_slice(std::int64_t slice, std::span<std::byte> out);
  Result<TiffFile*> open_file(std::uint32_t file);

  struct OpenFile {
    std::uint32_t index;
    std::unique_ptr<TiffFile> file;
  };

  TiffVolume volume_;
  std::vector<OpenFile> open_;  // the one that was used last is the last
  std::int64_t next_slice_ = 0;
};

}  // namespace gvx::io
