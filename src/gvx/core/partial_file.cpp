#include "gvx/core/partial_file.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace gvx {
namespace {

namespace fs = std::filesystem;
using FileStatus = struct ::stat;

constexpr int kMostLinks = 40;  // as Linux follows
constexpr mode_t kPermissions = 0777;

/// Every PATH.partial that this process owns. Held while one is made, renamed or removed, so that each is
/// known from the moment it exists. Never destroyed: threads may outlive main().
struct PartialNames {
  std::mutex mutex;
  std::vector<std::string> names;

  void add(const std::string& name) { names.push_back(name); }
  void remove(const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) names.erase(found);
  }
};

PartialNames& partial_names() {
  static auto* names = new PartialNames;
  return *names;
}

std::string reason(int error_number) {
  return std::system_category().message(error_number);
}

bool same_file(const FileStatus& a, const FileStatus& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/// The folder that holds `path`.
std::string folder_of(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

/// N where the name is that of this process's descriptor N: /dev/fd/N and the like.
std::optional<int> descriptor_named(const std::string& path) {
  const std::string number = fs::path(path).filename().string();
  if (number.empty() || number.size() > 6 || number.find_first_not_of("0123456789") != std::string::npos) {
    return std::nullopt;
  }
  FileStatus folder{}, descriptors{};
  if (::stat(folder_of(path).c_str(), &folder) != 0 || ::stat("/proc/self/fd", &descriptors) != 0 ||
      !same_file(folder, descriptors)) {
    return std::nullopt;
  }
  return std::stoi(number);
}

}  // namespace

Result<OutputPlace> find_output(const std::string& path) {
  fs::path at = path;
  for (int links = 0; links <= kMostLinks; ++links) {
    if (const auto number = descriptor_named(at.string())) {
      if (::fcntl(*number, F_GETFD) < 0) return Error{path + ": cannot write: " + reason(errno)};
      return OutputPlace{OutputPlace::Kind::descriptor, at.string(), true, *number};
    }
    FileStatus status{};
    if (::lstat(at.c_str(), &status) != 0) {
      if (errno != ENOENT) return Error{path + ": cannot create: " + reason(errno)};
      if (!at.has_filename()) return Error{path + ": cannot create: expected the name of a file"};
      return OutputPlace{OutputPlace::Kind::file, at.string(), false};
    }
    if (S_ISDIR(status.st_mode)) return Error{path + ": cannot create: a folder has that name"};
    if (S_ISREG(status.st_mode)) return OutputPlace{OutputPlace::Kind::file, at.string(), true};
    if (!S_ISLNK(status.st_mode)) return OutputPlace{OutputPlace::Kind::stream, at.string(), true};
    std::error_code error;
    const fs::path target = fs::read_symlink(at, error);
    if (error) return Error{path + ": cannot create: " + error.message()};
    at = at.parent_path() / target;  // which is `target` alone where that is absolute
  }
  return Error{path + ": cannot create: " + reason(ELOOP)};
}

Status check_writable(const std::string& path) {
  GVX_ASSIGN(const OutputPlace place, find_output(path));
  if (place.kind == OutputPlace::Kind::descriptor) return {};
  if (place.exists && ::access(place.path.c_str(), W_OK) != 0) {
    return Error{path + ": cannot write: " + reason(errno)};
  }
  if (place.kind == OutputPlace::Kind::file && ::access(folder_of(place.path).c_str(), W_OK | X_OK) != 0) {
    return Error{path + ": cannot create: folder " + folder_of(place.path) + ": " + reason(errno)};
  }
  return {};
}

Result<PartialFile> PartialFile::create(const std::string& path) {
  GVX_ASSIGN(OutputPlace place, find_output(path));
  PartialFile file(path, std::move(place));
  GVX_TRY(file.place_.kind == OutputPlace::Kind::file ? file.open_partial() : file.open_other());
  return file;
}

PartialFile::PartialFile(std::string path, OutputPlace place)
    : path_(std::move(path)), place_(std::move(place)), partial_path_(place_.path + ".partial") {}

PartialFile::PartialFile(PartialFile&& other) noexcept
    : path_(std::move(other.path_)),
      place_(std::move(other.place_)),
      partial_path_(std::move(other.partial_path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      partial_exists_(std::exchange(other.partial_exists_, false)) {}

PartialFile::~PartialFile() {
  if (partial_exists_) {
    const std::lock_guard lock(partial_names().mutex);
    ::unlink(partial_path_.c_str());
    partial_names().remove(partial_path_);
  }
  // After its name is gone, which belongs to whoever holds the lock.
  if (descriptor_ >= 0) ::close(descriptor_);
}

Error PartialFile::cannot(const std::string& name, const char* action) const {
  return Error{name + ": cannot " + action + ": " + reason(errno)};
}

Status PartialFile::open_partial() {
  FileStatus replaced{};
  const bool replaces = ::stat(place_.path.c_str(), &replaced) == 0;
  const std::lock_guard lock(partial_names().mutex);
  while (true) {
    descriptor_ = ::open(partial_path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, replaces ? 0600 : 0666);
    if (descriptor_ < 0) return cannot(partial_path_, "create");
    // The lock tells a process that is running from one that was killed: the latter's remains are
    // overwritten.
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      return Error{partial_path_ + ": another build or render is writing this file"};
    }
    // Another process may have finished in between, and what was opened be its file by now.
    FileStatus opened{}, named{};
    if (::fstat(descriptor_, &opened) == 0 && ::stat(partial_path_.c_str(), &named) == 0 &&
        same_file(opened, named)) {
      partial_exists_ = true;
      partial_names().add(partial_path_);
      if (S_ISREG(opened.st_mode) && ::ftruncate(descriptor_, 0) != 0) return cannot(partial_path_, "write");
      break;
    }
    ::close(std::exchange(descriptor_, -1));
  }
  if (replaces) {
    // Who may not give a file to its old owner keeps it as his own.
    const int ignored = ::fchown(descriptor_, replaced.st_uid, replaced.st_gid);
    (void)ignored;
    ::fchmod(descriptor_, replaced.st_mode & kPermissions);
  }
  return {};
}

Status PartialFile::open_other() {
  descriptor_ = place_.kind == OutputPlace::Kind::descriptor
                    ? ::fcntl(place_.descriptor, F_DUPFD_CLOEXEC, 0)
                    : ::open(place_.path.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
  return descriptor_ >= 0 ? Status() : cannot(path_, "open");
}

Status PartialFile::write(std::span<const std::byte> bytes) {
  GVX_CHECK(descriptor_ >= 0);
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
    if (count >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    } else if (errno != EINTR) {
      return cannot(name(), "write");
    }
  }
  return {};
}

Status PartialFile::commit() {
  GVX_CHECK(descriptor_ >= 0);
  // Network file systems report a full disk only when a descriptor is closed. This one holds the lock, and
  // goes last.
  const int copy = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
  if (copy < 0 || ::close(copy) != 0) return cannot(name(), "write");
  if (place_.kind == OutputPlace::Kind::file) {
    const std::lock_guard lock(partial_names().mutex);
    if (std::rename(partial_path_.c_str(), place_.path.c_str()) != 0) return cannot(path_, "create");
    partial_names().remove(partial_path_);
    partial_exists_ = false;
  }
  ::close(std::exchange(descriptor_, -1));
  return {};
}

std::unique_lock<std::mutex> guard_file_names() {
  return std::unique_lock(partial_names().mutex);
}

void remove_partial_files() {
  partial_names().mutex.lock();
  for (const std::string& name : partial_names().names) ::unlink(name.c_str());
}

}  // namespace gvx
