#include "gvx/io/inflate_stream.h"

#include <algorithm>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr int kWindowBitsDetectFormat = 15 + 32;
constexpr int kWindowBitsBare = -15;
constexpr std::size_t kLongestStep = std::size_t{1} << 30;  // zlib counts in 32 bits

bool starts_with_gzip_magic(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b};
}

}  // namespace

Result<std::unique_ptr<ByteStream>> InflateStream::create(FileSource source) {
  return start(std::move(source), false);
}

Result<std::unique_ptr<ByteStream>> InflateStream::create_bare(FileSource source) {
  return start(std::move(source), true);
}

Result<std::unique_ptr<ByteStream>> InflateStream::start(FileSource source, bool bare) {
  std::unique_ptr<InflateStream> stream(new InflateStream(std::move(source), bare));
  if (inflateInit2(&stream->state_, bare ? kWindowBitsBare : kWindowBitsDetectFormat) != Z_OK) {
    return file_error(stream->name(), "zlib cannot start: expected memory for its window");
  }
  return std::unique_ptr<ByteStream>(std::move(stream));
}

InflateStream::~InflateStream() {
  inflateEnd(&state_);
}

Status InflateStream::restart() {
  inflateReset(&state_);
  between_members_ = true;
  any_member_ = false;
  return {};
}

// Not gzread, which would own the file and cannot begin in its middle or read a zlib stream. As gzip(1) does,
// bytes behind the last member that do not begin another one are ignored: tapes and copies pad files.
Result<bool> InflateStream::next_member() {
  if (bare_ && any_member_) return false;
  GVX_ASSIGN(const auto bytes, source_.peek(2));
  if (any_member_ ? !starts_with_gzip_magic(bytes) : bytes.empty()) return false;
  inflateReset(&state_);
  between_members_ = false;
  any_member_ = true;
  return true;
}

Result<std::size_t> InflateStream::read(std::span<std::byte> out) {
  std::size_t done = 0;
  while (done < out.size()) {
    if (between_members_) {
      GVX_ASSIGN(const bool more, next_member());
      if (!more) break;
    }
    GVX_ASSIGN(const auto input, source_.peek());
    const std::size_t room = std::min(out.size() - done, kLongestStep);
    state_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(input.data()));
    state_.avail_in = static_cast<uInt>(input.size());
    state_.next_out = reinterpret_cast<Bytef*>(out.data() + done);
    state_.avail_out = static_cast<uInt>(room);
    const int status = inflate(&state_, Z_NO_FLUSH);
    source_.consume(input.size() - state_.avail_in);
    done += room - state_.avail_out;
    if (status == Z_STREAM_END) {
      between_members_ = true;
    } else if (status == Z_BUF_ERROR && input.empty()) {
      break;
    } else if (status != Z_OK && status != Z_BUF_ERROR) {
      const char* why = state_.msg != nullptr ? state_.msg : "unexpected code";
      return file_error(name(),
                        std::string(bare_ ? "broken deflated data: " : "broken gzip or zlib data: ") + why);
    }
  }
  return done;
}

}  // namespace gvx::io
