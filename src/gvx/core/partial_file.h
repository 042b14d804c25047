/// \file
/// Outputs: what stands behind the name of one, and files that are there whole or not at all. A file is
/// written under the name PATH.partial and renamed when it is complete. Devices, pipes and sockets, and
/// descriptors such as /dev/stdout, are written to and never replaced. Links are followed: a link stays, and
/// what it names is replaced.
#pragma once

#include <cstddef>
#include <mutex>
#include <span>
#include <string>

#include "gvx/core/result.h"

namespace gvx {

/// What stands behind the name of an output.
struct OutputPlace {
  enum class Kind {
    file,        ///< a regular file, or nothing yet
    stream,      ///< a device, a pipe or a socket
    descriptor,  ///< what this process has open under a number, such as /dev/stdout
  };
  Kind kind = Kind::file;
  std::string path;     ///< with every link followed
  bool exists = false;  ///< of a file
  int descriptor = -1;  ///< of a descriptor
};

/// Follows links, also one that names nothing yet. Fails where the name is that of a folder, or cannot be
/// looked at. Changes nothing.
Result<OutputPlace> find_output(const std::string& path);

/// Would PartialFile::create() work, as far as can be told without changing anything? An error where the
/// folder is not there or may not be written to, or the file or device may not.
Status check_writable(const std::string& path);

/// Owns PATH.partial until commit() gives it its name; destroyed before that, it removes what was written and
/// leaves whatever stood at PATH as it was. Guards against failures of the program and full disks, not of the
/// power supply. Of devices, pipes and descriptors it writes what comes at once.
class PartialFile {
 public:
  /// Creates PATH.partial with the permissions of the file that it will replace, if there is one, or opens
  /// the device. Fails where the folder cannot be written to, or another process is writing that file. What a
  /// killed process left under that name is overwritten.
  static Result<PartialFile> create(const std::string& path);

  PartialFile(PartialFile&& other) noexcept;
  PartialFile& operator=(PartialFile&&) = delete;
  ~PartialFile();

  /// Appends the bytes.
  Status write(std::span<const std::byte> bytes);

  /// For who writes at places of its own; readable and writable where it is a regular file.
  int descriptor() const { return descriptor_; }
  /// The name of what is written, for messages.
  const std::string& name() const { return place_.kind == OutputPlace::Kind::file ? partial_path_ : path_; }

  /// Closes the file and gives it its name, in place of a file of that name. Nothing can be written
  /// afterwards.
  Status commit();

 private:
  PartialFile(std::string path, OutputPlace place);
  Status open_partial();
  Status open_other();
  Error cannot(const std::string& name, const char* action) const;

  std::string path_;  // as it was asked for
  OutputPlace place_;
  std::string partial_path_;
  int descriptor_ = -1;  // -1 once closed
  bool partial_exists_ = false;
};

/// To be held while a file is made that loses its name at once: remove_partial_files() waits until then.
[[nodiscard]] std::unique_lock<std::mutex> guard_file_names();

/// Removes every PATH.partial that there is; from then on none can be made, committed or removed any more.
/// For a program that is ended by a signal: to be called from a thread of its own, not from a signal's
/// handler.
void remove_partial_files();

}  // namespace gvx
