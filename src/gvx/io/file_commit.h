/// \file
/// Files that are there whole or not at all: written under another name and renamed when complete.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "gvx/core/result.h"

namespace gvx::io {

/// Owns PATH.partial until commit() gives it its name; destroyed before that, it removes what was written and
/// leaves whatever stood at PATH as it was. Guards against failures of the program and full disks, not of the
/// power supply.
class PartialFile {
 public:
  /// Creates PATH.partial, or fails where the folder cannot be written to.
  static Result<PartialFile> create(const std::string& path);

  PartialFile(PartialFile&& other) noexcept;
  PartialFile& operator=(PartialFile&&) = delete;
  ~PartialFile();

  /// Appends the bytes.
  Status write(std::span<const std::byte> bytes);

  /// Closes the file and renames it to PATH, replacing a file of that name. Nothing can be written
  /// afterwards.
  Status commit();

 private:
  PartialFile(std::string path, int descriptor);

  std::string path_;
  std::string partial_path_;
  int descriptor_ = -1;  // -1 once closed
  bool partial_exists_ = true;
};

/// Creates or replaces `path` with the bytes; on failure nothing has changed.
Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes);

}  // namespace gvx::io
