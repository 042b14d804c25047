#include "gvx/io/check_read.h"

#include <string>

#include "gvx/io/header_text.h"

namespace gvx::io {

Status check_read(const SliceReader& reader, std::int64_t count, std::span<const std::byte> out) {
  const VolumeDescription& d = reader.description();
  const std::int64_t left = d.dimensions.z - reader.next_slice();
  if (count < 0 || count > left) {
    return file_error(d.path, "read_slices: " + std::to_string(count) + " slices, of which " +
                                  std::to_string(left) + " are left; rewind() goes back to the first");
  }
  const std::uint64_t bytes = static_cast<std::uint64_t>(count) * slice_bytes(d);
  if (out.size() != bytes) {
    return file_error(d.path, "read_slices: memory of " + std::to_string(out.size()) + " bytes for " +
                                  std::to_string(count) + " slices; expected " + std::to_string(bytes));
  }
  return {};
}

}  // namespace gvx::io
