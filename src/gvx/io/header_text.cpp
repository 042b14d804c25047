#include "gvx/io/header_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <span>

#include "gvx/io/file_source.h"

namespace gvx::io {
namespace {

constexpr std::string_view kWhiteSpace = " \t\r\n\v\f";

template <typename T>
std::optional<T> parse_whole(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  T parsed{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return parsed;
}

}  // namespace

Error file_error(const std::string& path, const std::string& message) {
  return Error{path + ": " + message};
}

std::string quoted(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest)) shown += c >= ' ' && c <= '~' ? c : '?';
  return shown + (text.size() > kLongest ? "...'" : "'");
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kWhiteSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kWhiteSpace) - first + 1);
}

std::string lower_case(std::string_view text) {
  std::string small(text);
  for (char& c : small) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return small;
}

std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> found;
  for (std::size_t at = text.find_first_not_of(kWhiteSpace); at != std::string_view::npos;) {
    const std::size_t end = text.find_first_of(kWhiteSpace, at);
    found.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kWhiteSpace, end);
  }
  return found;
}

std::optional<std::int64_t> parse_integer(std::string_view text) {
  return parse_whole<std::int64_t>(text);
}

std::optional<double> parse_number(std::string_view text) {
  return parse_whole<double>(text);
}

std::string number_text(double number) {
  std::array<char, 32> text;
  const double size = std::abs(number);
  const bool plain = number == 0 || (size >= 1e-5 && size < 1e17);
  const auto written = std::to_chars(text.data(), text.data() + text.size(), number,
                                     plain ? std::chars_format::fixed : std::chars_format::scientific);
  return std::string(text.data(), written.ptr);
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view word : words(text)) {
    const std::optional<double> number = parse_number(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

Result<std::string> read_file_start(const std::string& path) {
  GVX_ASSIGN(FileSource source, FileSource::open(path));
  std::string text(kMaximumHeaderBytes, '\0');
  GVX_ASSIGN(const std::size_t count, source.read(std::as_writable_bytes(std::span(text))));
  text.resize(count);
  return text;
}

std::string_view take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string beside(const std::string& header_path, std::string_view name) {
  return (std::filesystem::path(header_path).parent_path() / name).string();
}

}  // namespace gvx::io
