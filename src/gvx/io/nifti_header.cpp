#include "gvx/io/nifti_header.h"

#include <bit>
#include <cstddef>
#include <cstring>
#include <string_view>
#include <vector>

#include "gvx/io/header_text.h"

// nifticlib is not used: it prints to stderr about headers that it refuses, where gvx must say in a Result
// what was expected, and it reads whole volumes.

namespace gvx::io {
namespace {

constexpr std::uint32_t kNifti1Bytes = 348, kNifti2Bytes = 540;

/// The header's bytes; numbers are named by their byte offsets in nifti1.h or nifti2.h.
class Bytes {
 public:
  Bytes(std::vector<std::byte> bytes, bool big_endian) : bytes_(std::move(bytes)), big_endian_(big_endian) {}

  template <typename T>
  T get(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> ordered;
    const bool swap = big_endian_ != (std::endian::native == std::endian::big);
    for (std::size_t i = 0; i < sizeof(T); ++i) ordered[i] = bytes_[offset + (swap ? sizeof(T) - 1 - i : i)];
    return std::bit_cast<T>(ordered);
  }
  /// Numbers of type T that stand side by side.
  template <typename T, typename Number, std::size_t kCount>
  void fill(std::array<Number, kCount>& numbers, std::size_t offset) const {
    for (std::size_t i = 0; i < kCount; ++i) numbers[i] = static_cast<Number>(get<T>(offset + i * sizeof(T)));
  }
  bool has_magic(std::size_t offset, std::string_view magic) const {
    return std::memcmp(bytes_.data() + offset, magic.data(), magic.size()) == 0;
  }

 private:
  std::vector<std::byte> bytes_;
  bool big_endian_;
};

NiftiHeader nifti1(const Bytes& bytes) {
  NiftiHeader header;
  header.kind = bytes.has_magic(344, {"n+1\0", 4})   ? NiftiHeader::Kind::single
                : bytes.has_magic(344, {"ni1\0", 4}) ? NiftiHeader::Kind::pair
                                                     : NiftiHeader::Kind::analyze;
  bytes.fill<std::int16_t>(header.dim, 40);
  header.datatype = bytes.get<std::int16_t>(70);
  bytes.fill<float>(header.pixdim, 76);
  header.vox_offset = double{bytes.get<float>(108)};
  header.intent_code = bytes.get<std::int16_t>(68);
  header.scl_slope = double{bytes.get<float>(112)};
  header.scl_inter = double{bytes.get<float>(116)};
  header.xyzt_units = bytes.get<std::uint8_t>(123);
  header.qform_code = bytes.get<std::int16_t>(252);
  header.sform_code = bytes.get<std::int16_t>(254);
  bytes.fill<float>(header.quatern, 256);
  bytes.fill<float>(header.qoffset, 268);
  for (std::size_t row = 0; row < 3; ++row) bytes.fill<float>(header.srow[row], 280 + 16 * row);
  return header;
}

NiftiHeader nifti2(const Bytes& bytes, bool single) {
  NiftiHeader header;
  header.version = 2;
  header.kind = single ? NiftiHeader::Kind::single : NiftiHeader::Kind::pair;
  header.datatype = bytes.get<std::int16_t>(12);
  bytes.fill<std::int64_t>(header.dim, 16);
  bytes.fill<double>(header.pixdim, 104);
  header.vox_offset = static_cast<double>(bytes.get<std::int64_t>(168));
  header.intent_code = bytes.get<std::int32_t>(504);
  header.scl_slope = bytes.get<double>(176);
  header.scl_inter = bytes.get<double>(184);
  header.qform_code = bytes.get<std::int32_t>(344);
  header.sform_code = bytes.get<std::int32_t>(348);
  bytes.fill<double>(header.quatern, 352);
  bytes.fill<double>(header.qoffset, 376);
  for (std::size_t row = 0; row < 3; ++row) bytes.fill<double>(header.srow[row], 400 + 32 * row);
  header.xyzt_units = bytes.get<std::int32_t>(500);
  return header;
}

}  // namespace

Result<Encoding> detect_gzip(const std::string& path) {
  GVX_ASSIGN(FileSource source, FileSource::open(path));
  GVX_ASSIGN(const auto bytes, source.peek(2));
  const bool gzip = bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
  return gzip ? Encoding::gzip : Encoding::raw;
}

Result<NiftiHeader> read_nifti_header(const std::string& path) {
  GVX_ASSIGN(const Encoding encoding, detect_gzip(path));
  GVX_ASSIGN(const auto stream, open_byte_stream(path, encoding, {}, SampleType::u8));
  std::vector<std::byte> start(kNifti1Bytes);
  GVX_ASSIGN(const std::size_t count, stream->read(start));
  if (count < kNifti1Bytes) {
    return file_error(path, "header: expected 348 bytes, found " + std::to_string(count));
  }
  for (const bool big_endian : {false, true}) {
    const auto length = Bytes(start, big_endian).get<std::uint32_t>(0);
    if (length != kNifti1Bytes && length != kNifti2Bytes) continue;
    if (length == kNifti2Bytes) {
      start.resize(kNifti2Bytes);
      GVX_ASSIGN(const std::size_t more, stream->read(std::span(start).subspan(kNifti1Bytes)));
      if (more < kNifti2Bytes - kNifti1Bytes) {
        return file_error(path, "header: expected 540 bytes, found " + std::to_string(count + more));
      }
    }
    const Bytes bytes(std::move(start), big_endian);
    const bool single = bytes.has_magic(4, {"n+2\0", 4});
    if (length == kNifti2Bytes && !single && !bytes.has_magic(4, {"ni2\0", 4})) {
      return file_error(path, "magic: expected n+2 or ni2");
    }
    NiftiHeader header = length == kNifti2Bytes ? nifti2(bytes, single) : nifti1(bytes);
    header.big_endian = big_endian;
    return header;
  }
  return file_error(path, "sizeof_hdr: expected 348 (NIfTI-1) or 540 (NIfTI-2), found " +
                              std::to_string(Bytes(start, false).get<std::uint32_t>(0)));
}

}  // namespace gvx::io
