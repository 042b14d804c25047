#include "gvx/io/nrrd.h"

#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "gvx/io/header_text.h"
#include "gvx/io/nrrd_geometry.h"

namespace gvx::io {
namespace {

struct Header {
  NrrdFields fields;
  std::size_t bytes = 0;        // up to and with the empty line
  bool has_empty_line = false;  // behind which attached data begin
  std::string data_file_lines;  // behind "data file: LIST"
};

std::string canonical_name(std::string_view name) {
  std::string small = lower_case(trimmed(name));
  if (small == "datafile") return "data file";
  if (small == "lineskip") return "line skip";
  if (small == "byteskip") return "byte skip";
  if (small == "blocksize") return "block size";
  return small;
}

/// "LIST", and perhaps how many axes are in each of the files.
bool is_list(const std::string& data_file) {
  const std::vector<std::string_view> parts = words(data_file);
  return !parts.empty() && parts[0] == "LIST" && parts.size() <= 2;
}

Result<Header> split_header(const std::string& path, const std::string& text) {
  std::string_view rest = text;
  const std::string_view magic = take_line(rest);
  if (!magic.starts_with("NRRD000") || magic.size() != 8 || magic[7] < '1' || magic[7] > '5') {
    return file_error(path, "magic: expected NRRD0001 to NRRD0005, found " + quoted(magic));
  }
  Header header;
  while (!rest.empty()) {
    const std::string_view line = take_line(rest);
    if (line.empty()) {
      header.has_empty_line = true;
      break;
    }
    const std::size_t colon = line.find(':');
    const bool is_comment = line.front() == '#';
    const bool is_key_value = colon != std::string_view::npos && line.substr(colon).starts_with(":=");
    if (is_comment || is_key_value) continue;
    if (colon == std::string_view::npos) {
      return file_error(path, "header: expected 'field: value' in each line, found " + quoted(line));
    }
    const std::string name = canonical_name(line.substr(0, colon));
    if (!header.fields.emplace(name, trimmed(line.substr(colon + 1))).second) {
      return file_error(path, "header: expected each field once, found two of " + quoted(name));
    }
    if (name == "data file" && is_list(header.fields.at(name))) {
      if (text.size() == kMaximumHeaderBytes)
        return file_error(path, "data file: expected a list that ends within the first MiB");
      header.data_file_lines = rest;
      rest = {};
    }
  }
  header.bytes = text.size() - rest.size();
  if (!header.has_empty_line && text.size() == kMaximumHeaderBytes) {
    return file_error(path, "header: expected an empty line within the first MiB");
  }
  return header;
}

Result<std::string> required(const std::string& path, const NrrdFields& fields, const char* name) {
  const auto found = fields.find(name);
  if (found == fields.end()) return file_error(path, std::string(name) + ": expected this field");
  return found->second;
}

Result<std::int64_t> skip_count(const std::string& path, const NrrdFields& fields, const char* name,
                                std::int64_t minimum) {
  const auto found = fields.find(name);
  if (found == fields.end()) return 0;
  const auto count = parse_integer(found->second);
  if (!count || *count < minimum || *count > std::numeric_limits<std::int64_t>::max() / 4) {
    return file_error(path, std::string(name) + ": expected a number from " + std::to_string(minimum) +
                                ", found " + quoted(found->second));
  }
  return *count;
}

Result<Encoding> parse_encoding(const std::string& path, const std::string& text) {
  const std::string name = lower_case(text);
  if (name == "raw") return Encoding::raw;
  if (name == "gzip" || name == "gz") return Encoding::gzip;
  if (name == "bzip2" || name == "bz2") return Encoding::bzip2;
  if (name == "ascii" || name == "text" || name == "txt") return Encoding::ascii;
  return file_error(path, "encoding: expected raw, gzip, bzip2 or ascii, found " + quoted(text));
}

Status interpret_type(const std::string& path, const NrrdFields& fields, VolumeFile& file) {
  GVX_ASSIGN(const std::string type, required(path, fields, "type"));
  const auto parsed = parse_sample_type(type);
  if (!parsed)
    return file_error(path, std::string("type: expected ") + kSampleTypeNames + ", found " + quoted(type));
  file.description.type = *parsed;
  const auto endian = fields.find("endian");
  if (endian != fields.end()) {
    const std::string order = lower_case(endian->second);
    if (order != "little" && order != "big") {
      return file_error(path, "endian: expected little or big, found " + quoted(endian->second));
    }
    file.description.big_endian = order == "big";
  } else if (sample_bytes(*parsed) > 1 && file.encoding != Encoding::ascii) {
    return file_error(path, "endian: expected this field, because a sample has more than one byte");
  }
  return {};
}

/// Data files of which each has some of the axes: "LIST [AXES]" and lines of names, or "PATTERN FIRST LAST
/// STEP [AXES]".
Status interpret_data_files(const Header& header, VolumeFile& file) {
  const std::string& text = header.fields.at("data file");
  const std::vector<std::string_view> parts = words(text);
  std::vector<std::int64_t> sizes, numbers;
  for (const std::string_view size : words(header.fields.at("sizes"))) sizes.push_back(*parse_integer(size));
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const auto number = parse_integer(parts[i]);
    if (!number)
      return file_error(file.header_path,
                        "data file: expected numbers behind the first word of " + quoted(text));
    numbers.push_back(*number);
  }
  std::optional<std::vector<std::string>> names;
  std::size_t given = 0;  // numbers before that of the axes
  if (is_list(text)) {
    names = listed_names(header.data_file_lines);
  } else if (numbers.size() == 3 || numbers.size() == 4) {
    names = names_of_pattern(parts[0], numbers[0], numbers[1], numbers[2]);
    given = 3;
  }
  if (!names) {
    return file_error(file.header_path,
                      "data file: expected a pattern such as 'slice%03d.raw 1 100 1' of at most " +
                          std::to_string(kMostDataFiles) + " files, found " + quoted(text));
  }
  const std::int64_t most = static_cast<std::int64_t>(sizes.size()) - 1;
  return set_data_files(file, "data file", *names, sizes, numbers.size() > given ? numbers.back() : most);
}

Status interpret_data_place(const std::string& path, const Header& header, VolumeFile& file) {
  const auto data_file = header.fields.find("data file");
  if (data_file != header.fields.end()) {
    const std::string& name = data_file->second;
    if (name.empty()) return file_error(path, "data file: expected a name");
    if (is_list(name) || is_file_pattern(name)) {
      GVX_TRY(interpret_data_files(header, file));
    } else {
      file.data_paths = {beside(path, name)};
    }
  } else {
    if (!header.has_empty_line) return file_error(path, "header: expected an empty line before the data");
    file.data_paths = {path};
    file.start.file_offset = static_cast<std::int64_t>(header.bytes);
  }
  GVX_ASSIGN(file.start.line_skip, skip_count(path, header.fields, "line skip", 0));
  GVX_ASSIGN(file.byte_skip, skip_count(path, header.fields, "byte skip", kSamplesAtEnd));
  if (file.encoding == Encoding::ascii && file.byte_skip != 0) {
    return file_error(path,
                      "byte skip: expected 0 with encoding ascii, found " + std::to_string(file.byte_skip));
  }
  return {};
}

}  // namespace

Result<VolumeFile> parse_nrrd(const std::string& path) {
  GVX_ASSIGN(const std::string text, read_file_start(path));
  GVX_ASSIGN(const Header header, split_header(path, text));
  VolumeFile file;
  file.description.path = path;
  file.header_path = path;
  GVX_ASSIGN(const std::string encoding, required(path, header.fields, "encoding"));
  GVX_ASSIGN(file.encoding, parse_encoding(path, encoding));
  GVX_TRY(interpret_type(path, header.fields, file));
  GVX_TRY(interpret_nrrd_axes(header.fields, file.description));
  GVX_TRY(interpret_data_place(path, header, file));
  return file;
}

}  // namespace gvx::io
