#include "gvx/store/range_reader.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace gvx::store {
namespace {

class FileRanges final : public RangeReader {
 public:
  FileRanges(std::string path, int descriptor, std::uint64_t size)
      : path_(std::move(path)), descriptor_(descriptor), size_(size) {}
  ~FileRanges() override { close(descriptor_); }

  std::uint64_t size_bytes() const override { return size_; }

  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > size_ || out.size() > size_ - offset) {
      return Error{path_ + ": bytes " + std::to_string(offset) + " to " +
                   std::to_string(offset + out.size()) + " are beyond the end of the file (" +
                   std::to_string(size_) + " bytes)"};
    }
    while (!out.empty()) {
      const ssize_t got = pread(descriptor_, out.data(), out.size(), static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return Error{path_ + ": cannot read: " + std::strerror(errno)};
      if (got == 0) return Error{path_ + ": the file was cut while it was read"};
      offset += static_cast<std::uint64_t>(got);
      out = out.subspan(static_cast<std::size_t>(got));
    }
    return {};
  }

 private:
  std::string path_;
  int descriptor_;
  std::uint64_t size_;
};

}  // namespace

Result<std::unique_ptr<RangeReader>> open_file_ranges(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return Error{path + ": cannot open: " + std::strerror(errno)};
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    close(descriptor);
    return Error{path + ": not a regular file"};
  }
  return std::unique_ptr<RangeReader>(
      std::make_unique<FileRanges>(path, descriptor, static_cast<std::uint64_t>(status.st_size)));
}

}  // namespace gvx::store
