#include "gvx/io/file_commit.h"

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

Error cannot(const std::string& path, const char* action) {
  return file_error(path, std::string("cannot ") + action + ": " + std::system_category().message(errno));
}

}  // namespace

Result<PartialFile> PartialFile::create(const std::string& path) {
  const std::string partial_path = path + ".partial";
  const int descriptor = ::open(partial_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) return cannot(partial_path, "create");
  return PartialFile(path, descriptor);
}

PartialFile::PartialFile(std::string path, int descriptor)
    : path_(std::move(path)), partial_path_(path_ + ".partial"), descriptor_(descriptor) {}

PartialFile::PartialFile(PartialFile&& other) noexcept
    : path_(std::move(other.path_)),
      partial_path_(std::move(other.partial_path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      partial_exists_(std::exchange(other.partial_exists_, false)) {}

PartialFile::~PartialFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (partial_exists_) ::unlink(partial_path_.c_str());
}

Status PartialFile::write(std::span<const std::byte> bytes) {
  GVX_CHECK(descriptor_ >= 0);
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
    if (count >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    } else if (errno != EINTR) {
      return cannot(partial_path_, "write");
    }
  }
  return {};
}

Status PartialFile::commit() {
  GVX_CHECK(descriptor_ >= 0);
  // Network file systems report a full disk only here.
  if (::close(std::exchange(descriptor_, -1)) != 0) return cannot(partial_path_, "write");
  if (std::rename(partial_path_.c_str(), path_.c_str()) != 0) return cannot(path_, "create");
  partial_exists_ = false;
  return {};
}

Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  GVX_ASSIGN(PartialFile file, PartialFile::create(path));
  GVX_TRY(file.write(bytes));
  return file.commit();
}

}  // namespace gvx::io
