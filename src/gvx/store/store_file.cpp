#include "gvx/store/store_file.h"

#include <algorithm>
#include <vector>

#include "gvx/store/checksum.h"

namespace gvx::store {

Status StoreFile::read(std::uint64_t offset, std::span<std::byte> out) const {
  const TimeSum::Span reading(reading_);
  GVX_TRY(ranges_->read(offset, out));
  bytes_read_.fetch_add(out.size(), std::memory_order_relaxed);
  return {};
}

Result<std::uint64_t> StoreFile::checksum_of(std::uint64_t offset, std::uint64_t bytes) const {
  constexpr std::uint64_t kPiece = 1 << 20;
  std::vector<std::byte> piece(static_cast<std::size_t>(std::min(bytes, kPiece)));
  RunningChecksum sum;
  while (bytes > 0) {
    const std::span<std::byte> now(piece.data(), static_cast<std::size_t>(std::min(bytes, kPiece)));
    GVX_TRY(read(offset, now));
    sum.add(now);
    offset += now.size();
    bytes -= now.size();
  }
  return sum.value();
}

}  // namespace gvx::store
