#include "gvx/io/nrrd.h"

#include <limits>
#include <string_view>

#include "gvx/io/header_text.h"
#include "gvx/io/nrrd_geometry.h"

namespace gvx::io {
namespace {

struct Header {
  NrrdFields fields;
  std::size_t bytes = 0;        // up to and with the empty line
  bool has_empty_line = false;  // behind which attached data begin
};

std::string canonical_name(std::string_view name) {
  std::string small = lower_case(trimmed(name));
  if (small == "datafile") return "data file";
  if (small == "lineskip") return "line skip";
  if (small == "byteskip") return "byte skip";
  if (small == "blocksize") return "block size";
  return small;
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

Status interpret_data_place(const std::string& path, const Header& header, VolumeFile& file) {
  const auto data_file = header.fields.find("data file");
  if (data_file != header.fields.end()) {
    const std::string& name = data_file->second;
    if (name.empty()) return file_error(path, "data file: expected a name");
    if (name.starts_with("LIST") || name.find('%') != std::string::npos) {
      return file_error(
          path, "data file: expected one file; lists and patterns are not supported, found " + quoted(name));
    }
    file.data_paths = {beside(path, name)};
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
