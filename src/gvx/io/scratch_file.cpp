#include "gvx/io/scratch_file.h"

#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "gvx/core/partial_file.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

Error cannot(const std::string& folder, const char* action) {
  return file_error(
      folder, std::string("cannot ") + action + " a scratch file: " + std::system_category().message(errno));
}

/// Where the file system cannot make files without a name.
int create_and_unlink(const std::string& folder) {
  const auto guard = guard_file_names();
  std::string path = folder + "/gvx-scratch-XXXXXX";
  const int descriptor = ::mkostemp(path.data(), O_CLOEXEC);
  if (descriptor >= 0) ::unlink(path.c_str());
  return descriptor;
}

}  // namespace

Result<ScratchFile> ScratchFile::create(const std::string& folder) {
  int descriptor = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor < 0 && (errno == EOPNOTSUPP || errno == EISDIR)) descriptor = create_and_unlink(folder);
  if (descriptor < 0) return cannot(folder, "create");
  return ScratchFile(folder, descriptor);
}

ScratchFile::ScratchFile(std::string folder, int descriptor)
    : folder_(std::move(folder)), descriptor_(descriptor) {}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : folder_(std::move(other.folder_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string ScratchFile::path() const {
  return "/proc/self/fd/" + std::to_string(descriptor_);
}

Status ScratchFile::write(std::uint64_t position, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(position));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return cannot(folder_, "write");
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    position += static_cast<std::uint64_t>(count);
  }
  return {};
}

Status ScratchFile::read(std::uint64_t position, std::span<std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t count = ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(position));
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errno = EIO;
    if (count <= 0) return cannot(folder_, "read");
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    position += static_cast<std::uint64_t>(count);
  }
  return {};
}

}  // namespace gvx::io
