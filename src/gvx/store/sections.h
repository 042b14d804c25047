/// \file
/// Sections: named ranges of a store's file. What is not a brick or an index page is a section, so a store
/// can get new parts without a new version: a reader ignores the sections that it does not know, unless one
/// is marked as required.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gvx/core/result.h"
#include "gvx/store/store_file.h"

namespace gvx::store {

/// Names of the sections that every store has.
inline constexpr const char* kDirectorySection = "directory";
inline constexpr const char* kRecordsSection = "records";
inline constexpr const char* kMetadataSection = "metadata";

/// Bytes of a name in a store: printable ASCII, then zeros.
using StoredName = std::array<char, 24>;

/// The stored form of a name of 1 to 24 characters.
StoredName stored_name(const std::string& name);
/// The name, or empty where the bytes are not a name.
std::string name_of(const StoredName& stored);

/// What the file's table of sections says of one.
struct Section {
  std::string name;
  std::uint32_t version = 1;  ///< of the section's own layout
  bool required = false;      ///< must a reader know the section to read the store?
  std::uint64_t offset = 0, bytes = 0;
  std::uint64_t checksum = 0;  ///< of all its bytes
};

/// The section's bytes in the table.
struct SectionEntry {
  StoredName name;
  std::uint32_t version;
  std::uint32_t flags;  ///< bit 0: required
  std::uint64_t reserved;
  std::uint64_t offset, bytes, checksum;
};
static_assert(sizeof(SectionEntry) == 64);

/// The most sections that a table may have.
inline constexpr std::uint32_t kMostSections = 1024;

/// The table's entries, in the same order.
std::vector<SectionEntry> section_table(std::span<const Section> sections);

/// What the table's bytes say. An error where a name is none or stands there twice, or a section is not
/// within the file, whose header takes `header_bytes`, or shares bytes with another.
Result<std::vector<Section>> parse_sections(const StoreFile& file, std::span<const SectionEntry> table,
                                            std::uint64_t header_bytes);

/// Where a file's table of sections is, as its header says.
struct SectionTable {
  std::uint32_t sections = 0;
  std::uint64_t offset = 0, checksum = 0;
};

/// Reads the table, which must match its checksum, and parses it.
Result<std::vector<Section>> read_sections(const StoreFile& file, const SectionTable& table,
                                           std::uint64_t header_bytes);

/// An error where a section is required that has none of the names that the reader knows, or another version
/// than the first.
Status check_required(const StoreFile& file, std::span<const Section> sections,
                      std::span<const char* const> known);

/// The section of a name, or an error. `most_bytes` is what a sound one may have.
Result<Section> find_section(const StoreFile& file, std::span<const Section> sections, const char* name,
                             std::uint64_t most_bytes);

/// All bytes of a section, which must match its checksum.
Result<std::vector<std::byte>> read_section(const StoreFile& file, const Section& section);

}  // namespace gvx::store
