/// \file
/// AppendedFile: the file of a store while it is written. Bytes are appended behind a header, which comes
/// last: a file without one is no store. The file is called PATH.partial until it is whole and on the disk.
#pragma once

#include <cstdint>
#include <future>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/partial_file.h"
#include "gvx/core/result.h"
#include "gvx/store/format.h"
#include "gvx/store/sections.h"

namespace gvx::store {

/// For one thread. If it is destroyed before finish(), it removes the file.
class AppendedFile {
 public:
  /// Bytes that are written at once. Memory holds twice as many.
  static constexpr std::size_t kPendingBytes = 4 << 20;

  /// `header_bytes` are left free for finish(). `file` is new.
  AppendedFile(PartialFile file, std::uint64_t header_bytes);
  ~AppendedFile();
  AppendedFile(const AppendedFile&) = delete;
  AppendedFile& operator=(const AppendedFile&) = delete;

  /// Its name until it is finished, for messages.
  const std::string& partial_path() const { return partial_path_; }
  /// Where the next bytes will stand.
  std::uint64_t end() const { return end_; }

  /// An error after finish().
  Status append(std::span<const std::byte> bytes);
  /// Appends bytes to which something else will refer.
  Result<BlockRef> add_block(std::span<const std::byte> bytes);
  /// Appends a section. Readers that do not know its name ignore it; if it is `required`, they refuse the
  /// store.
  Status add_section(const std::string& name, std::uint32_t version, bool required,
                     std::span<const std::byte> bytes);
  /// A section that was appended piece by piece, from `offset` on, with this checksum.
  Status end_section(const std::string& name, std::uint32_t version, bool required, std::uint64_t offset,
                     std::uint64_t checksum);

  /// Appends the table of sections.
  Result<SectionTable> add_table();
  /// Writes the header, waits for the disk, and gives the file its name. Nothing can be added afterwards.
  Status finish(std::span<const std::byte> header);

 private:
  Status check_section(const std::string& name) const;
  Status write_pending();
  Status wait_for_writing();
  Status write_at(std::uint64_t offset, std::span<const std::byte> bytes);

  PartialFile file_;
  std::string partial_path_;  // its name
  int descriptor_;            // of it
  std::uint64_t end_;
  std::vector<std::byte> pending_;        // appended, but not written yet: the last before end_
  std::vector<std::byte> being_written_;  // those before them
  std::future<Status> writing_;
  std::vector<Section> sections_;
};

}  // namespace gvx::store
