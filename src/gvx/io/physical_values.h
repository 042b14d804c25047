/// \file
/// PhysicalValueReader: the slices of another reader, as physical values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/io/volume_reader.h"

namespace gvx::io {

/// Hands out scale * sample + offset as f64; its own description has a scale of 1 and an offset of 0. A value
/// within 2e-7 of a whole number, relatively, is that number: headers hold scales as floats. Values that are
/// beyond doubles are the greatest double. Uses another reader, which must outlive it.
class PhysicalValueReader final : public SliceReader {
 public:
  explicit PhysicalValueReader(SliceReader& stored);

  const VolumeDescription& description() const override { return description_; }
  Status read_slices(std::int64_t count, std::span<std::byte> out) override;
  std::int64_t next_slice() const override { return stored_.next_slice(); }
  Status rewind() override { return stored_.rewind(); }
  bool can_rewind() const override { return stored_.can_rewind(); }
  std::vector<Surplus> surplus() override { return stored_.surplus(); }

 private:
  SliceReader& stored_;
  VolumeDescription description_;
  std::vector<std::byte> samples_;  // a slice as it is stored
};

}  // namespace gvx::io
