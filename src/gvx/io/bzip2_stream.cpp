#include "gvx/io/bzip2_stream.h"

#include <algorithm>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::size_t kLongestStep = std::size_t{1} << 30;  // libbz2 counts in 32 bits

}  // namespace

Result<std::unique_ptr<ByteStream>> Bzip2Stream::create(FileSource source) {
  return std::unique_ptr<ByteStream>(new Bzip2Stream(std::move(source)));
}

Bzip2Stream::~Bzip2Stream() {
  if (open_) BZ2_bzDecompressEnd(&state_);
}

Status Bzip2Stream::restart() {
  if (open_) BZ2_bzDecompressEnd(&state_);
  open_ = false;
  any_member_ = false;
  return {};
}

Result<bool> Bzip2Stream::next_member() {
  GVX_ASSIGN(const auto bytes, source_.peek(3));
  const bool magic = bytes.size() >= 3 && bytes[0] == std::byte{'B'} && bytes[1] == std::byte{'Z'} &&
                     bytes[2] == std::byte{'h'};
  if (any_member_ ? !magic : bytes.empty()) return false;
  state_ = {};
  if (BZ2_bzDecompressInit(&state_, 0, 0) != BZ_OK) {
    return file_error(name(), "bzip2 cannot start: expected memory for its state");
  }
  open_ = true;
  any_member_ = true;
  return true;
}

Result<std::size_t> Bzip2Stream::read(std::span<std::byte> out) {
  std::size_t done = 0;
  while (done < out.size()) {
    if (!open_) {
      GVX_ASSIGN(const bool more, next_member());
      if (!more) break;
    }
    GVX_ASSIGN(const auto input, source_.peek());
    const std::size_t room = std::min(out.size() - done, kLongestStep);
    state_.next_in = reinterpret_cast<char*>(const_cast<std::byte*>(input.data()));
    state_.avail_in = static_cast<unsigned>(input.size());
    state_.next_out = reinterpret_cast<char*>(out.data() + done);
    state_.avail_out = static_cast<unsigned>(room);
    const int status = BZ2_bzDecompress(&state_);
    const std::size_t made = room - state_.avail_out;
    source_.consume(input.size() - state_.avail_in);
    done += made;
    if (status == BZ_STREAM_END) {
      BZ2_bzDecompressEnd(&state_);
      open_ = false;
    } else if (status != BZ_OK) {
      return file_error(name(), "broken bzip2 data: code " + std::to_string(status));
    } else if (input.empty() && made == 0) {
      break;
    }
  }
  return done;
}

}  // namespace gvx::io
