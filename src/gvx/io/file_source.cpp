#include "gvx/io/file_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{256} << 10;
constexpr std::size_t kLongestPeek = 16;

std::string reason(int error_number) {
  return std::system_category().message(error_number);
}

}  // namespace

Result<FileSource> FileSource::open(const std::string& path) {
  const bool standard_input = path == "-";
  const std::string name = standard_input ? "standard input" : path;
  const int descriptor = standard_input ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return file_error(name, "cannot open: " + reason(errno));
  FileSource source(name, descriptor);
  struct stat about {};
  if (fstat(descriptor, &about) != 0) return file_error(name, "cannot open: " + reason(errno));
  if (S_ISDIR(about.st_mode)) return file_error(name, "is a folder, expected a file");
  const off_t position = lseek(descriptor, 0, SEEK_CUR);
  source.seekable_ = position >= 0;
  if (position > 0) source.file_position_ = static_cast<std::uint64_t>(position);
  if (S_ISREG(about.st_mode)) source.size_ = static_cast<std::uint64_t>(about.st_size);
  return source;
}

FileSource::FileSource(std::string name, int descriptor)
    : name_(std::move(name)), descriptor_(descriptor), buffer_(kBufferBytes) {}

FileSource::FileSource(FileSource&& other) noexcept
    : name_(std::move(other.name_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      seekable_(other.seekable_),
      size_(other.size_),
      file_position_(other.file_position_),
      buffer_(std::move(other.buffer_)),
      begin_(other.begin_),
      end_(other.end_) {}

FileSource::~FileSource() {
  if (descriptor_ >= 0 && descriptor_ != STDIN_FILENO) ::close(descriptor_);
}

Result<std::size_t> FileSource::read_descriptor(std::span<std::byte> out) {
  for (;;) {
    const ssize_t count = ::read(descriptor_, out.data(), out.size());
    if (count >= 0) {
      file_position_ += static_cast<std::uint64_t>(count);
      return static_cast<std::size_t>(count);
    }
    if (errno != EINTR) return file_error(name_, "cannot read: " + reason(errno));
  }
}

Result<std::span<const std::byte>> FileSource::peek(std::size_t minimum) {
  GVX_CHECK(minimum <= kLongestPeek);
  while (end_ - begin_ < minimum) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
    GVX_ASSIGN(const std::size_t count, read_descriptor(std::span(buffer_).subspan(end_)));
    if (count == 0) break;
    end_ += count;
  }
  return std::span<const std::byte>(buffer_).subspan(begin_, end_ - begin_);
}

void FileSource::consume(std::size_t count) {
  GVX_CHECK(count <= end_ - begin_);
  begin_ += count;
}

Result<std::size_t> FileSource::read(std::span<std::byte> out) {
  std::size_t done = std::min(out.size(), end_ - begin_);
  if (done != 0) std::memcpy(out.data(), buffer_.data() + begin_, done);
  begin_ += done;
  while (done < out.size()) {
    GVX_ASSIGN(const std::size_t count, read_descriptor(out.subspan(done)));
    if (count == 0) break;
    done += count;
  }
  return done;
}

bool FileSource::comes_within(std::chrono::milliseconds time) const {
  if (end_ > begin_) return true;
  pollfd waiting{descriptor_, POLLIN, 0};
  return ::poll(&waiting, 1, static_cast<int>(time.count())) > 0;
}

Status FileSource::seek(std::uint64_t position) {
  const bool possible = position <= std::uint64_t{std::numeric_limits<off_t>::max()};
  if (!seekable_ || !possible || lseek(descriptor_, static_cast<off_t>(position), SEEK_SET) < 0) {
    return file_error(name_,
                      "cannot go to byte " + std::to_string(position) + ": expected a file, not a pipe");
  }
  file_position_ = position;
  begin_ = end_ = 0;
  return {};
}

std::optional<std::uint64_t> FileSource::bytes_left() const {
  if (!size_) return std::nullopt;
  return *size_ > position() ? *size_ - position() : 0;
}

}  // namespace gvx::io
