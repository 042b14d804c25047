#include "gvx/io/recognise.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "gvx/io/byte_stream.h"
#include "gvx/io/format_table.h"
#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeadBytes = 4096;
// Of a folder no more entries are looked at.
constexpr std::size_t kMostEntries = 4096;
// Files that a sentence about a folder names.
constexpr std::size_t kMostNames = 3;

enum class Packing { none, gzip, bzip2 };

/// The first bytes of a file, unpacked.
struct Head {
  std::string bytes;
  Packing packing = Packing::none;
};

std::string read_head(const std::string& path, Encoding encoding) {
  std::string head(kHeadBytes, '\0');
  const auto stream = open_byte_stream(path, encoding, {}, SampleType::u8);
  if (!stream.ok()) return {};
  // Byte by byte where the packed bytes are broken further on: what came before the break counts.
  const auto all = stream.value()->read(std::as_writable_bytes(std::span(head)));
  if (all.ok()) {
    head.resize(all.value());
    return head;
  }
  if (!stream.value()->rewind().ok()) return {};
  std::size_t size = 0;
  for (; size < head.size(); ++size) {
    const auto got = stream.value()->read(std::as_writable_bytes(std::span(head).subspan(size, 1)));
    if (!got.ok() || got.value() == 0) break;
  }
  head.resize(size);
  return head;
}

Head read_head(const std::string& path) {
  Head head{read_head(path, Encoding::raw)};
  if (head.bytes.starts_with("\x1f\x8b")) return {read_head(path, Encoding::gzip), Packing::gzip};
  if (head.bytes.starts_with("BZh")) return {read_head(path, Encoding::bzip2), Packing::bzip2};
  return head;
}

/// The name in small letters without its folder, and without the ending of packed files.
std::string name_of(const std::string& path) {
  std::string name = lower_case(fs::path(path).filename().string());
  if (name.empty()) name = lower_case(path);
  for (const char* packed : {".gz", ".bz2"}) {
    if (name.ends_with(packed)) name.resize(name.size() - std::string_view(packed).size());
  }
  return name;
}

std::string sentence(const Format& format) {
  if (format.why.empty()) return {};
  return std::string(format.name) + " " + std::string(format.why) + "; " + std::string(format.instead);
}

Recognised as(const Format& format, bool by_content) {
  return {format.kind, by_content, false, sentence(format)};
}

const Format* by_content(std::string_view head, std::string_view name) {
  for (const Format& format : formats()) {
    if (has_magic(format, head) && (!format.needs_both || has_ending(format, name))) return &format;
  }
  return nullptr;
}

const Format* by_name(std::string_view name) {
  for (const Format& format : formats()) {
    if (!format.needs_both && has_ending(format, name)) return &format;
  }
  return nullptr;
}

/// The format with this ending, for what is told by more than a few bytes.
const Format* of_ending(std::string_view ending) {
  return by_name(ending);
}

/// XML that says what it is in its first tag.
const Format* xml_format(std::string_view head) {
  if (head.find("<COLLADA") != std::string_view::npos) return of_ending(".dae");
  if (head.find("<X3D") != std::string_view::npos) return of_ending(".x3d");
  if (head.find("<svg") != std::string_view::npos) return of_ending(".svg");
  const std::size_t vtk = head.find("<VTKFile");
  if (vtk == std::string_view::npos) return nullptr;
  const std::string_view tag = head.substr(vtk, std::min(head.find('>', vtk), head.size()) - vtk);
  if (tag.find("ImageData\"") != std::string_view::npos) return of_ending(".vti");
  return of_ending(tag.find("PolyData\"") != std::string_view::npos ? ".vtp" : ".vtu");
}

bool is_text(std::string_view head) {
  return !head.empty() && std::all_of(head.begin(), head.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x20 ? byte != 0x7f : byte == '\n' || byte == '\r' || byte == '\t' || byte == '\f';
  });
}

std::string text_problem(std::string_view head) {
  const std::string_view start = trimmed(head);
  if (start.starts_with('{') || start.starts_with('[')) {
    return "JSON is neither a volume nor a mesh; gvx render takes a scene file, whose name ends in .json";
  }
  if (start.starts_with('<'))
    return "XML of a kind that gvx does not know; name the volume or mesh file itself";
  return "Text is neither a volume nor a mesh; name the volume or mesh file itself";
}

Recognised recognise_file(const std::string& path) {
  const std::string name = name_of(path);
  std::error_code error;
  // To look into a pipe would take away what is in it.
  const bool regular = fs::is_regular_file(path, error);
  if (regular && fs::file_size(path, error) == 0 && !error) {
    return {FileKind::other, true, false, "the file is empty; expected a volume or a mesh"};
  }
  const Head head = regular ? read_head(path) : Head{};
  if (const Format* format = by_content(head.bytes, name)) return as(*format, true);
  if (const Format* format = xml_format(std::string_view(head.bytes).substr(0, 1024)))
    return as(*format, true);
  if (const Format* format = by_name(name)) return as(*format, false);
  if (head.bytes.starts_with(std::string_view("\x5c\x01\0\0", 4)) ||
      head.bytes.starts_with(std::string_view("\0\0\x01\x5c", 4))) {
    return as(*of_ending(".hdr"), true);  // Analyze 7.5: 348, the size of its header
  }
  if (is_text(head.bytes)) return {FileKind::other, true, false, text_problem(head.bytes)};
  if (head.packing != Packing::none) {
    return {FileKind::other, true, false,
            "it is packed, and what is in it is not known; raw samples need their shape (--dims, --dtype)"};
  }
  return {};
}

// Folders.

bool there(const std::string& folder, const char* name) {
  std::error_code error;
  return fs::exists(fs::path(folder) / name, error);
}

Recognised other_folder(std::string problem) {
  return {FileKind::other, true, true, std::move(problem)};
}

/// What files of one format in a folder are called, and the first of them.
struct Found {
  std::size_t count = 0;
  std::vector<std::string> names;
};

std::string counted(const Found& found, std::string_view plural) {
  return std::to_string(found.count) + " " + std::string(plural);
}

std::string listed(const Found& found) {
  std::string text;
  for (const std::string& name : found.names) text += (text.empty() ? "" : ", ") + name;
  return text + (found.count > found.names.size() ? ", ..." : "");
}

/// The format of a file in a folder; the first bytes are only read of those whose names say nothing.
const Format* format_in_folder(const fs::directory_entry& entry, std::size_t& left_to_open) {
  const std::string path = entry.path().string(), name = name_of(path);
  if (const Format* format = by_name(name)) return format;
  if (left_to_open == 0) return nullptr;
  --left_to_open;
  return by_content(read_head(path).bytes, name);
}

/// What is in a folder.
struct Contents {
  bool empty = true;
  std::string problem;                   ///< why it could not be read
  std::map<const Format*, Found> files;  ///< by their formats, without those that hold no data
  Found stores;                          ///< folders that are Zarr or N5
  Found folders;                         ///< others
  Found notes;                           ///< files of text and the like
};

bool holds_no_data(const Format& format) {
  return has_ending(format, ".txt") || has_ending(format, ".pdf") || has_ending(format, ".exe");
}

void add(Found& found, const fs::directory_entry& entry) {
  if (++found.count <= kMostNames) found.names.push_back(entry.path().filename().string());
}

Contents look_into(const std::string& folder) {
  std::vector<fs::directory_entry> all;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end && all.size() < kMostEntries;
       at.increment(error)) {
    all.push_back(*at);
  }
  std::sort(all.begin(), all.end());
  Contents contents;
  contents.empty = all.empty();
  if (error) contents.problem = error.message();
  std::size_t left_to_open = 64;
  for (const fs::directory_entry& entry : all) {
    std::error_code ignored;
    const std::string path = entry.path().string();
    if (entry.is_directory(ignored)) {
      const bool zarr = there(path, ".zgroup") || there(path, ".zarray") || there(path, "zarr.json");
      add(zarr || there(path, "attributes.json") ? contents.stores : contents.folders, entry);
    } else if (entry.is_regular_file(ignored)) {
      const Format* format = format_in_folder(entry, left_to_open);
      if (format != nullptr) add(holds_no_data(*format) ? contents.notes : contents.files[format], entry);
    }
  }
  return contents;
}

/// What a folder is taken for among the formats in it: a series comes with notes and previews.
int weight(const Format& format) {
  if (format.kind == FileKind::dicom || format.kind == FileKind::tiff) return 2;
  return format.kind == FileKind::other || format.kind == FileKind::raw ? 0 : 1;
}

Recognised recognise_folder(const std::string& path) {
  if (there(path, ".zarray") || there(path, ".zgroup") || there(path, "zarr.json")) {
    return other_folder(
        "a Zarr folder is not read yet; write one level of it as NRRD, for example with Python "
        "(zarr and pynrrd) or Fiji");
  }
  if (there(path, "attributes.json")) {
    return other_folder("an N5 folder is not read yet; write one level of it as NRRD, for example with Fiji");
  }
  const Contents contents = look_into(path);
  if (!contents.problem.empty()) return other_folder("cannot open: " + contents.problem);
  if (there(path, "info") && contents.files.empty()) {
    return other_folder(
        "a folder of neuroglancer's precomputed chunks is not read yet; write one level of it as "
        "NRRD, for example with Python (cloud-volume and pynrrd)");
  }
  const auto most =
      std::max_element(contents.files.begin(), contents.files.end(), [](const auto& a, const auto& b) {
        return std::pair(weight(*a.first), a.second.count) < std::pair(weight(*b.first), b.second.count);
      });
  if (most == contents.files.end()) {
    if (contents.stores.count > 0) {
      return other_folder("a folder of Zarr or N5 folders, which are not read yet: " +
                          listed(contents.stores));
    }
    if (contents.folders.count > 0) {
      return other_folder("a folder of folders; name one that holds a volume, such as " +
                          listed(contents.folders));
    }
    return other_folder(contents.empty ? "the folder is empty"
                                       : "a folder without a volume or a mesh that gvx knows");
  }
  const auto& [format, files] = *most;
  if (format->kind == FileKind::dicom) return {FileKind::dicom, true, true, {}};
  if (format->why.empty() || (format->kind == FileKind::other && files.count == 1)) {
    return other_folder("a folder, not a file; name " +
                        (files.count == 1 ? "the file in it: "
                                          : "one of the " + counted(files, format->plural) + " in it: ") +
                        listed(files));
  }
  return {
      format->kind, true, true,
      "a folder of " + counted(files, format->plural) + " is not read yet; " + std::string(format->instead)};
}

}  // namespace

Recognised recognise(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error) ? recognise_folder(path) : recognise_file(path);
}

FileKind kind_by_name(const std::string& path) {
  const Format* format = by_name(name_of(path));
  return format == nullptr ? FileKind::unknown : format->kind;
}

Error not_read(const std::string& path, const Recognised& found) {
  return file_error(path, found.problem);
}

}  // namespace gvx::io
