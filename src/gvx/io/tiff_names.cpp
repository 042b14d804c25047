#include "gvx/io/tiff_names.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
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

/// How much greater the number of b is, where the names differ in one number only.
std::optional<std::int64_t> step_between(std::string_view a, std::string_view b) {
  // From the front of the number in which they differ.
  std::size_t begin = 0;
  while (begin < std::min(a.size(), b.size()) && a[begin] == b[begin]) ++begin;
  while (begin > 0 && is_digit(a[begin - 1])) --begin;
  const auto end_of_number = [&](std::string_view text) {
    std::size_t end = begin;
    while (end < text.size() && is_digit(text[end])) ++end;
    return end;
  };
  const std::size_t end_a = end_of_number(a), end_b = end_of_number(b);
  if (a.substr(end_a) != b.substr(end_b)) return std::nullopt;
  const auto number_a = parse_integer(a.substr(begin, end_a - begin));
  const auto number_b = parse_integer(b.substr(begin, end_b - begin));
  if (!number_a || !number_b || *number_a >= *number_b) return std::nullopt;
  return *number_b - *number_a;
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

Result<std::vector<std::string>> tiff_names(const std::string& folder_or_pattern,
                                            std::vector<std::string>* no_files) {
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
    if (!entries->is_regular_file(ignored)) {
      if (no_files != nullptr && no_files->size() < static_cast<std::size_t>(kMostDataFiles))
        no_files->push_back(name);
      continue;
    }
    names.push_back(name);
    if (names.size() > static_cast<std::size_t>(kMostDataFiles)) {
      return file_error(folder_or_pattern,
                        "expected at most " + std::to_string(kMostDataFiles) + " TIFF files");
    }
  }
  if (failure) return file_error(folder_or_pattern, "cannot read the folder: " + failure.message());
  std::sort(names.begin(), names.end(), in_natural_order);
  if (no_files != nullptr) std::sort(no_files->begin(), no_files->end(), in_natural_order);
  for (std::string& name : names) name = (folder / name).string();
  return names;
}

std::string gaps_in_numbers(const std::vector<std::string>& names) {
  std::vector<std::optional<std::int64_t>> steps;
  std::map<std::int64_t, std::size_t> count_of;
  for (std::size_t i = 1; i < names.size(); ++i) {
    steps.push_back(step_between(names[i - 1], names[i]));
    if (steps.back()) ++count_of[*steps.back()];
  }
  if (count_of.empty()) return {};
  // The first of the most frequent ones, and so the smallest.
  const std::int64_t usual = std::max_element(count_of.begin(), count_of.end(), [](auto& a, auto& b) {
                               return a.second < b.second;
                             })->first;
  std::size_t gaps = 0, first = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] && *steps[i] > usual && gaps++ == 0) first = i;
  }
  if (gaps == 0) return {};
  const auto name = [&](std::size_t i) { return std::filesystem::path(names[i]).filename().string(); };
  return "numbers are missing between " + name(first) + " and " + name(first + 1) +
         (gaps == 1
              ? ""
              : " and in " + std::to_string(gaps - 1) + (gaps == 2 ? " other place" : " other places")) +
         "; the slices are read as neighbours";
}

}  // namespace gvx::io
