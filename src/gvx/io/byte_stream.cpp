#include "gvx/io/byte_stream.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "gvx/io/ascii_stream.h"
#include "gvx/io/bzip2_stream.h"
#include "gvx/io/header_text.h"
#include "gvx/io/inflate_stream.h"

namespace gvx::io {
namespace {

class RawStream final : public ByteStream {
 public:
  explicit RawStream(FileSource source) : ByteStream(std::move(source)) {}

  Result<std::size_t> read(std::span<std::byte> out) override { return source_.read(out); }

  Result<std::uint64_t> skip(std::uint64_t count) override {
    const std::optional<std::uint64_t> left = source_.bytes_left();
    if (!left || !source_.seekable()) return ByteStream::skip(count);
    const std::uint64_t skipped = std::min(count, *left);
    GVX_TRY(source_.seek(source_.position() + skipped));
    return skipped;
  }

  std::optional<std::uint64_t> bytes_left() const override { return source_.bytes_left(); }

 private:
  Status restart() override { return {}; }
};

Status skip_file_bytes(FileSource& source, std::uint64_t count) {
  if (count == 0) return {};
  if (source.seekable() && source.bytes_left().value_or(0) >= count) {
    return source.seek(source.position() + count);
  }
  for (std::uint64_t left = count; left != 0;) {
    GVX_ASSIGN(const auto bytes, source.peek());
    if (bytes.empty()) {
      return file_error(source.name(),
                        "ends before byte " + std::to_string(count) + ", where the data should begin");
    }
    const std::size_t step = static_cast<std::size_t>(std::min<std::uint64_t>(left, bytes.size()));
    source.consume(step);
    left -= step;
  }
  return {};
}

Status skip_lines(FileSource& source, std::int64_t count) {
  for (std::int64_t line = 0; line < count;) {
    GVX_ASSIGN(const auto bytes, source.peek());
    if (bytes.empty()) {
      return file_error(source.name(), "line skip: expected " + std::to_string(count) +
                                           " lines before the data, found " + std::to_string(line));
    }
    const auto end = std::find(bytes.begin(), bytes.end(), std::byte{'\n'});
    const bool whole = end != bytes.end();
    source.consume(static_cast<std::size_t>(end - bytes.begin()) + (whole ? 1 : 0));
    line += whole ? 1 : 0;
  }
  return {};
}

}  // namespace

ByteStream::ByteStream(FileSource source) : source_(std::move(source)), start_(source_.position()) {}

Result<std::uint64_t> ByteStream::skip(std::uint64_t count) {
  std::vector<std::byte> scratch(static_cast<std::size_t>(std::min<std::uint64_t>(count, 1 << 16)));
  std::uint64_t skipped = 0;
  while (skipped < count) {
    const auto step = static_cast<std::size_t>(std::min<std::uint64_t>(count - skipped, scratch.size()));
    GVX_ASSIGN(const std::size_t done, read(std::span(scratch).first(step)));
    skipped += done;
    if (done < step) break;
  }
  return skipped;
}

Status ByteStream::rewind() {
  GVX_TRY(source_.seek(start_));
  return restart();
}

Result<std::unique_ptr<ByteStream>> open_byte_stream(const std::string& path, Encoding encoding,
                                                     const StreamStart& start, SampleType type) {
  GVX_CHECK(start.file_offset >= 0 && start.line_skip >= 0);
  GVX_ASSIGN(FileSource source, FileSource::open(path));
  GVX_TRY(skip_file_bytes(source, static_cast<std::uint64_t>(start.file_offset)));
  GVX_TRY(skip_lines(source, start.line_skip));
  switch (encoding) {
    case Encoding::gzip:
      return InflateStream::create(std::move(source));
    case Encoding::bzip2:
      return Bzip2Stream::create(std::move(source));
    case Encoding::ascii:
      return make_ascii_stream(std::move(source), type);
    case Encoding::raw:
      break;
  }
  return std::unique_ptr<ByteStream>(std::make_unique<RawStream>(std::move(source)));
}

}  // namespace gvx::io
