#include "gvx/io/nifti_header.h"

#include "gvx/io/header_text.h"

// nifticlib is not used: it prints to stderr about headers that it refuses and repairs others (lengths below
// 1, a missing byte order) in silence, where gvx must say in a Result what was expected.

namespace gvx::io {
namespace {

constexpr std::uint32_t kNifti2HeaderBytes = 540;

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
  NiftiHeader header;
  GVX_ASSIGN(const std::size_t count, stream->read(header.bytes));
  if (count < kNiftiHeaderBytes) {
    return file_error(path, "header: expected 348 bytes, found " + std::to_string(count));
  }
  for (const bool big_endian : {false, true}) {
    header.big_endian = big_endian;
    const auto length = header.get<std::uint32_t>(0);
    if (length == kNiftiHeaderBytes) return header;
    if (length == kNifti2HeaderBytes)
      return file_error(path, "sizeof_hdr: expected NIfTI-1 (348), found NIfTI-2 (540)");
  }
  header.big_endian = false;
  return file_error(path, "sizeof_hdr: expected 348, found " + std::to_string(header.get<std::uint32_t>(0)));
}

}  // namespace gvx::io
