#include "gvx/io/tiff_names.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "gvx/io/header_text.h"
#include "gvx/io/volume_file.h"

namespace gvx::io {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// With * for any characters, ? for one, and # for the digits of one number.
bool matches(std::string_view name, std::string_view pattern) {
  // Where the last * stands in the pattern, and what it has taken so far.
  std::size_t n = 0, p = 0, star = std::string_view::npos, taken = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '#' && is_digit(name[n])) {
      while (n < name.size() && is_digit(name[n])) ++n;
      ++p;
    } else if (p < pattern.size() && pattern[p] == '*') {
      star = p++, taken = n;
    } else if (p < pattern.size() && pattern[p] != '#' && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p, ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1, n = ++taken;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

/// "z%04d.tif" as "z#.tif".
std::string with_number_marked(std::string pattern) {
  const std::size_t begin = pattern.find('%');
  if (begin == std::string::npos) return pattern;
  std::size_t end = begin + 1;
  while (end < pattern.size() && is_digit(pattern[end])) ++end;
  return pattern.replace(begin, end + 1 - begin, "#");
}

}  // namespace

bool is_tiff_name(std::string_view path) {
  const std::string name = lower_case(path);
  for (const char* extension : {".tif", ".tiff", ".btf", ".tf2", ".tf8"}) {
    if (name.ends_with(extension)) return true;
  }
  return false;
}

bool is_tiff_pattern(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  std::error_code ignored;
  return is_tiff_name(name) && (name.find_first_of("*?") != std::string::npos || is_file_pattern(name)) &&
         !std::filesystem::exists(path, ignored);
}

bool in_natural_order(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a, whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const auto number = [](std::string_view& text) {
        std::size_t end = 0;
        while (end < text.size() && is_digit(text[end])) ++end;
        std::string_view digits = text.substr(0, end);
        text.remove_prefix(end);
        digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
        return digits;
      };
      const std::string_view number_a = number(a), number_b = number(b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
      continue;
    }
    if (a.front() != b.front()) return a.front() < b.front();
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;
}

Result<std::vector<std::string>> tiff_names(const std::string& folder_or_pattern) {
  namespace fs = std::filesystem;
  std::error_code failure;
  const bool is_folder = fs::is_directory(folder_or_pattern, failure);
  const fs::path folder = is_folder ? fs::path(folder_or_pattern) : fs::path(folder_or_pattern).parent_path();
  const std::string pattern =
      is_folder ? "*" : with_number_marked(fs::path(folder_or_pattern).filename().string());
  std::vector<std::string> names;
  fs::directory_iterator entries(folder.empty() ? fs::path(".") : folder, failure);
  for (; !failure && entries != fs::directory_iterator(); entries.increment(failure)) {
    const std::string name = entries->path().filename().string();
    // Hidden files are not slices: macOS puts one of its own, ._z1.tif, beside each on foreign disks.
    if (name.starts_with('.') || !is_tiff_name(name) || !matches(name, pattern)) continue;
    std::error_code ignored;
    if (!entries->is_regular_file(ignored)) continue;
    names.push_back(name);
    if (names.size() > static_cast<std::size_t>(kMostDataFiles)) {
      return file_error(folder_or_pattern,
                        "expected at most " + std::to_string(kMostDataFiles) + " TIFF files");
    }
  }
  if (failure) return file_error(folder_or_pattern, "cannot read the folder: " + failure.message());
  std::sort(names.begin(), names.end(), in_natural_order);
  for (std::string& name : names) name = (folder / name).string();
  return names;
}

}  // namespace gvx::io
