#include "gvx/io/metaimage.h"

#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "gvx/io/header_text.h"

namespace gvx::io {
namespace {

/// Fields by name in small letters, up to ElementDataFile, which is the last.
class Header {
 public:
  static Result<Header> split(const std::string& path, const std::string& text) {
    Header header(path);
    std::string_view rest = text;
    while (!rest.empty()) {
      const std::string_view line = take_line(rest);
      if (trimmed(line).empty()) continue;
      const std::size_t equals = line.find('=');
      if (equals == std::string_view::npos) {
        return file_error(path, "header: expected 'field = value' in each line, found " + quoted(line));
      }
      const std::string name = lower_case(trimmed(line.substr(0, equals)));
      if (!header.fields_.emplace(name, trimmed(line.substr(equals + 1))).second) {
        return file_error(path, "header: expected each field once, found two of " + quoted(name));
      }
      header.bytes_ = text.size() - rest.size();
      if (name != "elementdatafile") continue;
      if (header.lists_files()) {
        if (text.size() == kMaximumHeaderBytes) {
          return file_error(path, "ElementDataFile: expected a list that ends within the first MiB");
        }
        header.data_file_lines_ = rest;
      }
      return header;
    }
    return file_error(path,
                      "ElementDataFile: expected this field in the header, which is at most 1 MiB long");
  }

  std::size_t bytes() const { return bytes_; }

  /// Is ElementDataFile "LIST", perhaps with how many axes are in each of the files?
  bool lists_files() const {
    const std::vector<std::string_view> parts = words(fields_.at("elementdatafile"));
    return !parts.empty() && lower_case(parts[0]) == "list" && parts.size() <= 2;
  }
  /// The lines behind it.
  const std::string& data_file_lines() const { return data_file_lines_; }

  /// The first of the names that is there.
  const std::string* find(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      const auto found = fields_.find(lower_case(name));
      if (found != fields_.end()) return &found->second;
    }
    return nullptr;
  }

  /// True, False or absent, which is false.
  Result<bool> flag(std::initializer_list<const char*> names) const {
    const std::string* text = find(names);
    if (text == nullptr) return false;
    const std::string value = lower_case(*text);
    if (value == "true" || value == "1") return true;
    if (value == "false" || value == "0") return false;
    return file_error(path_,
                      std::string(*names.begin()) + ": expected True or False, found " + quoted(*text));
  }

  /// Exactly `count` finite numbers; an empty list where the field is absent.
  Result<std::vector<double>> numbers(std::initializer_list<const char*> names, std::size_t count) const {
    const std::string* text = find(names);
    if (text == nullptr) return std::vector<double>{};
    const auto values = parse_numbers(*text);
    bool good = values && values->size() == count;
    for (std::size_t i = 0; good && i < count; ++i) good = std::isfinite((*values)[i]);
    if (good) return *values;
    return file_error(path_, std::string(*names.begin()) + ": expected " + std::to_string(count) +
                                 " finite numbers, found " + quoted(*text));
  }

 private:
  explicit Header(const std::string& path) : path_(path) {}

  std::string path_;
  std::map<std::string, std::string> fields_;
  std::string data_file_lines_;
  std::size_t bytes_ = 0;
};

Result<SampleType> parse_element_type(const std::string& path, const std::string& text) {
  const std::string name = lower_case(text);
  if (name == "met_long") return SampleType::i32;  // MetaIO's long has four bytes on every machine
  if (name == "met_ulong") return SampleType::u32;
  if (name == "met_long_long") return SampleType::i64;
  if (name == "met_ulong_long") return SampleType::u64;
  if (name.starts_with("met_")) {
    if (const auto type = parse_sample_type(std::string_view(name).substr(4))) return *type;
  }
  return file_error(
      path,
      "ElementType: expected MET_CHAR, MET_UCHAR, MET_SHORT, MET_USHORT, MET_INT, MET_UINT, MET_LONG_LONG, "
      "MET_ULONG_LONG, MET_FLOAT or MET_DOUBLE, found " +
          quoted(text));
}

/// Sets dimensions; returns how many axes the file states.
Result<std::size_t> interpret_size(const Header& header, VolumeDescription& description) {
  const std::string& path = description.path;
  const std::string* stated = header.find({"NDims"});
  const auto count = stated != nullptr ? parse_integer(*stated) : std::nullopt;
  if (!count || *count < 2 || *count > 4) {
    return file_error(path, "NDims: expected 3 (or 2, or 4 with one time step), found " +
                                (stated != nullptr ? quoted(*stated) : "nothing"));
  }
  const std::string* sizes = header.find({"DimSize"});
  const std::vector<std::string_view> lengths =
      sizes != nullptr ? words(*sizes) : std::vector<std::string_view>{};
  if (lengths.size() != static_cast<std::size_t>(*count)) {
    return file_error(path, "DimSize: expected " + std::to_string(*count) + " numbers, found " +
                                (sizes != nullptr ? quoted(*sizes) : "nothing"));
  }
  description.dimensions = {1, 1, 1};
  for (int axis = 0; axis < *count; ++axis) {
    const auto length = parse_integer(lengths[static_cast<std::size_t>(axis)]);
    if (!length || *length < 1)
      return file_error(path, "DimSize: expected numbers from 1, found " + quoted(*sizes));
    if (axis < 3) {
      description.dimensions[axis] = *length;
    } else if (*length != 1) {
      return file_error(path, "DimSize: expected one volume, found " + std::to_string(*length));
    }
  }
  return lengths.size();
}

Status interpret_place(const Header& header, std::size_t axes, VolumeDescription& description) {
  GVX_ASSIGN(const auto spacing, header.numbers({"ElementSpacing", "ElementSize"}, axes));
  GVX_ASSIGN(const auto offset, header.numbers({"Offset", "Position", "Origin"}, axes));
  GVX_ASSIGN(const auto matrix, header.numbers({"TransformMatrix", "Orientation", "Rotation"}, axes * axes));
  const int shared = axes < 3 ? 2 : 3;
  Affine3 index_to_world;
  for (int axis = 0; axis < shared; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    for (int row = 0; row < shared && !matrix.empty(); ++row) {
      index_to_world.column[axis][row] = matrix[a * axes + static_cast<std::size_t>(row)];
    }
    if (!spacing.empty()) {
      if (spacing[a] <= 0) {
        return file_error(description.path, "ElementSpacing: expected numbers greater than 0, found " +
                                                quoted(*header.find({"ElementSpacing", "ElementSize"})));
      }
      index_to_world.column[axis] = spacing[a] * index_to_world.column[axis];
    }
    if (!offset.empty()) index_to_world.origin[axis] = offset[a];
  }
  const std::string* orientation = header.find({"AnatomicalOrientation"});
  const bool orientation_known = orientation != nullptr && orientation->find('?') == std::string::npos;
  description.anatomical = orientation_known || !matrix.empty() || !offset.empty();
  description.voxel_to_world = index_to_world;
  if (description.anatomical) {
    description.voxel_to_world = with_world_scaled(from_index_to_centre(index_to_world), {-1, -1, 1});
  }
  return {};
}

Status interpret_values(const Header& header, VolumeFile& file) {
  VolumeDescription& description = file.description;
  GVX_ASSIGN(const auto channels, header.numbers({"ElementNumberOfChannels"}, 1));
  if (!channels.empty()) {
    if (channels[0] != 1 && channels[0] != 2 && channels[0] != 3 && channels[0] != 4) {
      return file_error(description.path, "ElementNumberOfChannels: expected 1 to 4, found " +
                                              quoted(*header.find({"ElementNumberOfChannels"})));
    }
    description.components = static_cast<int>(channels[0]);
  }
  const std::string* type = header.find({"ElementType"});
  if (type == nullptr) return file_error(description.path, "ElementType: expected this field");
  GVX_ASSIGN(description.type, parse_element_type(description.path, *type));
  GVX_ASSIGN(description.big_endian, header.flag({"BinaryDataByteOrderMSB", "ElementByteOrderMSB"}));
  GVX_ASSIGN(const auto slope, header.numbers({"ElementToIntensityFunctionSlope"}, 1));
  GVX_ASSIGN(const auto intercept, header.numbers({"ElementToIntensityFunctionOffset"}, 1));
  if (!slope.empty()) description.scale = slope[0];
  if (!intercept.empty()) description.offset = intercept[0];
  GVX_ASSIGN(const bool compressed, header.flag({"CompressedData"}));
  GVX_ASSIGN(const bool binary, header.flag({"BinaryData"}));
  if (compressed) file.encoding = Encoding::gzip;
  if (!compressed && !binary && header.find({"BinaryData"}) != nullptr) file.encoding = Encoding::ascii;
  return {};
}

/// Data files of which each has some of the axes: "LIST [AXES]" and lines of names, or "PATTERN [FIRST [LAST
/// [STEP]]]", a file for each place along the last axis.
Status interpret_data_files(const Header& header, VolumeFile& file) {
  const std::string& text = *header.find({"ElementDataFile"});
  const std::vector<std::string_view> parts = words(text);
  std::vector<std::int64_t> sizes, numbers;
  for (const std::string_view size : words(*header.find({"DimSize"}))) sizes.push_back(*parse_integer(size));
  for (std::size_t i = 1; i < parts.size(); ++i) {
    std::string_view part = parts[i];
    if (part.ends_with('D') || part.ends_with('d')) part.remove_suffix(1);  // "LIST 2D"
    const auto number = parse_integer(part);
    if (!number) {
      return file_error(file.header_path,
                        "ElementDataFile: expected numbers behind the first word of " + quoted(text));
    }
    numbers.push_back(*number);
  }
  std::int64_t axes_in_file = static_cast<std::int64_t>(sizes.size()) - 1;
  std::optional<std::vector<std::string>> names;
  if (header.lists_files()) {
    if (!numbers.empty()) axes_in_file = numbers[0];
    names = listed_names(header.data_file_lines());
  } else if (numbers.size() <= 3) {
    const std::int64_t first = numbers.empty() ? 1 : numbers[0];
    std::int64_t last = 0;
    if (__builtin_add_overflow(first, sizes.back() - 1, &last))
      last = std::numeric_limits<std::int64_t>::max();
    names = names_of_pattern(parts[0], first, numbers.size() > 1 ? numbers[1] : last,
                             numbers.size() > 2 ? numbers[2] : 1);
  }
  if (!names) {
    return file_error(file.header_path,
                      "ElementDataFile: expected a pattern such as 'slice%03d.raw 1 100 1' of at most " +
                          std::to_string(kMostDataFiles) + " files, found " + quoted(text));
  }
  return set_data_files(file, "ElementDataFile", *names, sizes, axes_in_file);
}

Status interpret_data_place(const Header& header, VolumeFile& file) {
  const std::string& path = file.description.path;
  const std::string& name = *header.find({"ElementDataFile"});
  const std::string small = lower_case(name);
  if (small == "local") {
    file.data_paths = {path};
    file.start.file_offset = static_cast<std::int64_t>(header.bytes());
  } else if (name.empty()) {
    return file_error(path, "ElementDataFile: expected LOCAL, LIST or a name");
  } else if (header.lists_files() || is_file_pattern(name)) {
    GVX_TRY(interpret_data_files(header, file));
  } else {
    file.data_paths = {beside(path, name)};
  }
  const std::string* skipped = header.find({"HeaderSize"});
  if (skipped == nullptr) return {};
  const auto bytes = parse_integer(*skipped);
  if (!bytes || *bytes < -1 || *bytes > std::numeric_limits<std::int64_t>::max() / 4) {
    return file_error(path, "HeaderSize: expected a number from -1, found " + quoted(*skipped));
  }
  if (*bytes == -1) {
    if (file.encoding != Encoding::raw) {
      return file_error(path, "HeaderSize: expected a number from 0 for data that are not raw, found -1");
    }
    file.byte_skip = kSamplesAtEnd;
  } else if (*bytes > 0) {
    file.start.file_offset = *bytes;
  }
  return {};
}

}  // namespace

Result<VolumeFile> parse_metaimage(const std::string& path) {
  GVX_ASSIGN(const std::string text, read_file_start(path));
  GVX_ASSIGN(const Header header, Header::split(path, text));
  VolumeFile file;
  file.description.path = path;
  file.header_path = path;
  GVX_ASSIGN(const std::size_t axes, interpret_size(header, file.description));
  GVX_TRY(interpret_place(header, axes, file.description));
  GVX_TRY(interpret_values(header, file));
  GVX_TRY(interpret_data_place(header, file));
  return file;
}

}  // namespace gvx::io
