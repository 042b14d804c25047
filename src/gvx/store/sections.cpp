#include "gvx/store/sections.h"

#include <algorithm>
#include <set>

#include "gvx/store/checksum.h"

namespace gvx::store {
namespace {

constexpr std::uint32_t kRequired = 1;
/// The layouts that this program knows, of all sections that it reads.
constexpr std::uint32_t kKnownVersion = 1;

}  // namespace

StoredName stored_name(const std::string& name) {
  StoredName stored{};
  GVX_CHECK(!name.empty() && name.size() <= stored.size());
  std::copy(name.begin(), name.end(), stored.begin());
  return stored;
}

std::string name_of(const StoredName& stored) {
  const auto end = std::find(stored.begin(), stored.end(), '\0');
  const bool zeros = std::all_of(end, stored.end(), [](char c) { return c == '\0'; });
  const bool printable = std::all_of(stored.begin(), end, [](char c) { return c > ' ' && c < 127; });
  return zeros && printable ? std::string(stored.begin(), end) : std::string();
}

std::vector<SectionEntry> section_table(std::span<const Section> sections) {
  std::vector<SectionEntry> table;
  for (const Section& s : sections) {
    table.push_back(
        {stored_name(s.name), s.version, s.required ? kRequired : 0, 0, s.offset, s.bytes, s.checksum});
  }
  return table;
}

Result<std::vector<Section>> parse_sections(const StoreFile& file, std::span<const SectionEntry> table,
                                            std::uint64_t header_bytes) {
  std::vector<Section> sections;
  std::set<std::string> names;
  for (const SectionEntry& entry : table) {
    const std::string name = name_of(entry.name);
    if (name.empty()) {
      return file.corrupt("section " + std::to_string(sections.size()) + " has no printable name");
    }
    if (!names.insert(name).second) return file.corrupt("there are two sections \"" + name + "\"");
    if (entry.offset < header_bytes || !file.has(entry.offset, entry.bytes)) {
      return file.corrupt("section \"" + name + "\" is not within the file");
    }
    sections.push_back(
        {name, entry.version, (entry.flags & kRequired) != 0, entry.offset, entry.bytes, entry.checksum});
  }
  std::vector<const Section*> in_order;
  for (const Section& section : sections) in_order.push_back(&section);
  std::sort(in_order.begin(), in_order.end(), [](const Section* a, const Section* b) {
    return a->offset != b->offset ? a->offset < b->offset : a->bytes < b->bytes;
  });
  for (std::size_t i = 1; i < in_order.size(); ++i) {
    if (in_order[i - 1]->offset + in_order[i - 1]->bytes > in_order[i]->offset) {
      return file.corrupt("sections \"" + in_order[i - 1]->name + "\" and \"" + in_order[i]->name +
                          "\" share bytes");
    }
  }
  return sections;
}

Result<std::vector<Section>> read_sections(const StoreFile& file, const SectionTable& table,
                                           std::uint64_t header_bytes) {
  if (table.sections > kMostSections) {
    return file.corrupt(std::to_string(table.sections) + " sections; at most " +
                        std::to_string(kMostSections) + " are expected");
  }
  std::vector<SectionEntry> entries(table.sections);
  const auto bytes = std::as_writable_bytes(std::span(entries));
  if (!file.has(table.offset, bytes.size())) {
    return file.corrupt("the table of sections is not within the file");
  }
  GVX_TRY(file.read(table.offset, bytes));
  if (checksum(bytes) != table.checksum) {
    return file.corrupt("the checksum of the table of sections does not match");
  }
  return parse_sections(file, entries, header_bytes);
}

Status check_required(const StoreFile& file, std::span<const Section> sections,
                      std::span<const char* const> known) {
  for (const Section& section : sections) {
    const bool has_name = std::ranges::any_of(known, [&](const char* name) { return section.name == name; });
    if (!section.required || (has_name && section.version == kKnownVersion)) continue;
    return Error{file.path() + ": made by a newer gvx: this program does not know section \"" + section.name +
                 "\" (version " + std::to_string(section.version) + "), which is required to read the store"};
  }
  return {};
}

Result<Section> find_section(const StoreFile& file, std::span<const Section> sections, const char* name,
                             std::uint64_t most_bytes) {
  const auto found =
      std::find_if(sections.begin(), sections.end(), [&](const Section& s) { return s.name == name; });
  if (found == sections.end()) return file.corrupt(std::string("section \"") + name + "\" is missing");
  if (found->bytes > most_bytes) {
    return file.corrupt(std::string("section \"") + name + "\" has " + std::to_string(found->bytes) +
                        " bytes; at most " + std::to_string(most_bytes) + " are expected");
  }
  return *found;
}

Result<std::vector<std::byte>> read_section(const StoreFile& file, const Section& section) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(section.bytes));
  GVX_TRY(file.read(section.offset, bytes));
  if (checksum(bytes) != section.checksum) {
    return file.corrupt("the checksum of section \"" + section.name + "\" does not match");
  }
  return bytes;
}

}  // namespace gvx::store
