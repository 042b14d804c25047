#include "gvx/store/appended_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <unistd.h>

#include "gvx/store/checksum.h"

namespace gvx::store {

AppendedFile::AppendedFile(PartialFile file, std::uint64_t header_bytes)
    : file_(std::move(file)),
      partial_path_(file_.name()),
      descriptor_(file_.descriptor()),
      end_(header_bytes) {}

AppendedFile::~AppendedFile() {
  (void)wait_for_writing();
}

Status AppendedFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return Error{partial_path_ + ": cannot write: " + std::strerror(errno)};
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

Status AppendedFile::append(std::span<const std::byte> bytes) {
  if (file_.descriptor() < 0) return Error{partial_path_ + ": the store is complete; nothing can be added"};
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  end_ += bytes.size();
  return pending_.size() < kPendingBytes ? Status() : write_pending();
}

/// Has what was appended written while the caller goes on; an error of what was written before.
Status AppendedFile::write_pending() {
  GVX_TRY(wait_for_writing());
  std::swap(pending_, being_written_);
  pending_.clear();
  const std::uint64_t start = end_ - being_written_.size();
  writing_ = std::async(std::launch::async, [this, start]() -> Status {
    GVX_TRY(write_at(start, being_written_));
    // Waiting for the disk here, beside the caller's work, leaves little to wait for at the end: a device
    // flushes its own cache for as long as there is data in it.
    if (fdatasync(descriptor_) != 0) return Error{partial_path_ + ": cannot write: " + std::strerror(errno)};
    return {};
  });
  return {};
}

Status AppendedFile::wait_for_writing() {
  return writing_.valid() ? writing_.get() : Status();
}

Result<BlockRef> AppendedFile::add_block(std::span<const std::byte> bytes) {
  const BlockRef block{end_, static_cast<std::uint32_t>(bytes.size()),
                       static_cast<std::uint32_t>(checksum(bytes))};
  GVX_TRY(append(bytes));
  return block;
}

Status AppendedFile::check_section(const std::string& name) const {
  const auto printable = [](char c) { return c > ' ' && c < 127; };
  if (name.empty() || name.size() > StoredName().size() || !std::ranges::all_of(name, printable)) {
    return Error{partial_path_ + ": section \"" + name + "\": expected a name of 1 to " +
                 std::to_string(StoredName().size()) + " printable characters without a space"};
  }
  if (std::ranges::any_of(sections_, [&](const Section& s) { return s.name == name; })) {
    return Error{partial_path_ + ": section \"" + name + "\" is there already"};
  }
  return {};
}

Status AppendedFile::add_section(const std::string& name, std::uint32_t version, bool required,
                                 std::span<const std::byte> bytes) {
  const std::uint64_t offset = end_;
  GVX_TRY(check_section(name));
  GVX_TRY(append(bytes));
  return end_section(name, version, required, offset, checksum(bytes));
}

Status AppendedFile::end_section(const std::string& name, std::uint32_t version, bool required,
                                 std::uint64_t offset, std::uint64_t checksum) {
  GVX_TRY(check_section(name));
  sections_.push_back({name, version, required, offset, end_ - offset, checksum});
  return {};
}

Result<SectionTable> AppendedFile::add_table() {
  const auto entries = section_table(sections_);
  const auto bytes = std::as_bytes(std::span(entries));
  const SectionTable table{static_cast<std::uint32_t>(entries.size()), end_, checksum(bytes)};
  GVX_TRY(append(bytes));
  return table;
}

Status AppendedFile::finish(std::span<const std::byte> header) {
  GVX_TRY(write_pending());
  GVX_TRY(wait_for_writing());
  GVX_TRY(write_at(0, header));
  if (fsync(descriptor_) != 0) return Error{partial_path_ + ": cannot write: " + std::strerror(errno)};
  return file_.commit();
}

}  // namespace gvx::store
