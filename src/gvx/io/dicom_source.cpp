#include "gvx/io/dicom_source.h"

#include <algorithm>
#include <array>
#include <utility>

#include "gvx/io/header_text.h"
#include "gvx/io/inflate_stream.h"

namespace gvx::io {
namespace {

// A shorter way is read through: to seek throws away what is buffered.
constexpr std::uint64_t kShortWay = 1 << 16;

}  // namespace

DicomSource::DicomSource(std::string name, std::unique_ptr<ByteStream> stream)
    : name_(std::move(name)), stream_(std::move(stream)), size_(stream_->bytes_left()) {}

Result<DicomSource> DicomSource::open(const std::string& path) {
  bool packed = false;
  {
    GVX_ASSIGN(FileSource file, FileSource::open(path));
    if (!file.seekable()) return file_error(path, "expected a file, not a pipe");
    GVX_ASSIGN(const auto magic, file.peek(2));
    packed = magic.size() >= 2 && magic[0] == std::byte{0x1f} && magic[1] == std::byte{0x8b};
  }
  GVX_ASSIGN(auto stream,
             open_byte_stream(path, packed ? Encoding::gzip : Encoding::raw, {}, SampleType::u8));
  return DicomSource(path, std::move(stream));
}

Status DicomSource::inflate_from(std::uint64_t offset) {
  if (!size_) return file_error(name_, "deflated twice: expected one of gzip and a deflated data set");
  GVX_ASSIGN(FileSource file, FileSource::open(name_));
  GVX_TRY(file.seek(offset));
  GVX_ASSIGN(stream_, InflateStream::create_bare(std::move(file)));
  at_ = 0;
  size_.reset();
  return {};
}

Result<std::size_t> DicomSource::read(std::uint64_t offset, std::span<std::byte> out) {
  if (size_ && offset >= *size_) return std::size_t{0};
  if (offset < at_) {
    GVX_TRY(stream_->rewind());
    at_ = 0;
  }
  if (size_ && offset - at_ <= kShortWay) {
    std::array<std::byte, 4096> passed;
    while (at_ < offset) {
      const auto step = static_cast<std::size_t>(std::min<std::uint64_t>(offset - at_, passed.size()));
      GVX_ASSIGN(const std::size_t done, stream_->read(std::span(passed).first(step)));
      at_ += done;
      if (done < step) return std::size_t{0};
    }
  } else {
    GVX_ASSIGN(const std::uint64_t done, stream_->skip(offset - at_));
    at_ += done;
    if (at_ < offset) return std::size_t{0};
  }
  GVX_ASSIGN(const std::size_t done, stream_->read(out));
  at_ += done;
  return done;
}

}  // namespace gvx::io
