#include "units.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>
#include <vector>

namespace gvx::app {
namespace {

template <typename Number>
std::optional<Number> parse(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

Error bad(const std::string& text, const char* expected) {
  return Error{"'" + text + "' is not " + expected};
}

}  // namespace

Result<std::uint64_t> parse_bytes(const std::string& text) {
  std::string_view digits = text;
  int shift = 0;
  const auto strip = [&](std::string_view suffix, int bits) {
    if (shift == 0 && digits.size() > suffix.size() && digits.ends_with(suffix)) {
      digits.remove_suffix(suffix.size());
      shift = bits;
    }
  };
  for (const auto& [letter, bits] :
       {std::pair('K', 10), std::pair('M', 20), std::pair('G', 30), std::pair('T', 40)}) {
    const std::string upper(1, letter), lower(1, static_cast<char>(letter + 32));
    for (const std::string& s : {upper, lower}) {
      strip(s + "iB", bits);
      strip(s + "B", bits);
      strip(s, bits);
    }
  }
  const auto value = parse<double>(digits);
  if (!value || !(*value > 0) || *value * std::exp2(shift) >= 0x1p62)
    return bad(text, "a size such as 512M or 2G");
  return static_cast<std::uint64_t>(*value * std::exp2(shift));
}

Result<std::chrono::nanoseconds> parse_duration(const std::string& text) {
  std::string_view digits = text;
  double milliseconds = 1;
  if (digits.ends_with("ms")) {
    digits.remove_suffix(2);
  } else if (digits.ends_with("s")) {
    digits.remove_suffix(1);
    milliseconds = 1000;
  }
  const auto value = parse<double>(digits);
  if (!value || !(*value > 0) || *value * milliseconds > 1e9) return bad(text, "a time such as 33ms or 2s");
  return std::chrono::nanoseconds(static_cast<std::int64_t>(*value * milliseconds * 1e6));
}

std::optional<Size> parse_size(const std::string& text) {
  const std::size_t x = text.find('x');
  if (x != std::string::npos) {
    const auto width = parse<std::uint32_t>(std::string_view(text).substr(0, x));
    const auto height = parse<std::uint32_t>(std::string_view(text).substr(x + 1));
    if (width && height && *width > 0 && *height > 0) return Size{*width, *height};
  }
  return std::nullopt;
}

std::optional<std::vector<double>> parse_list(const std::string& text) {
  std::string_view left = text;
  std::vector<double> values;
  while (true) {
    const std::size_t end = std::min(left.find(','), left.size());
    const auto value = parse<double>(left.substr(0, end));
    if (!value || !std::isfinite(*value)) return std::nullopt;
    values.push_back(*value);
    if (end == left.size()) return values;
    left.remove_prefix(end + 1);
  }
}

Result<Vec3d> parse_vec3(const std::string& text) {
  const auto v = parse_list(text);
  if (!v || v->size() != 3) return bad(text, "three numbers, as X,Y,Z");
  return Vec3d((*v)[0], (*v)[1], (*v)[2]);
}

Result<Vec3d> parse_color(const std::string& text) {
  const auto v = parse_list(text);
  if (!v || v->size() != 3) return bad(text, "red,green,blue: three numbers such as 0.2,0.3,0.4");
  return Vec3d((*v)[0], (*v)[1], (*v)[2]);
}

std::string bytes_text(std::uint64_t bytes) {
  const char* units[] = {"bytes", "KiB", "MiB", "GiB", "TiB", "PiB"};
  double value = static_cast<double>(bytes);
  int unit = 0;
  for (; value >= 1024 && unit < 5; ++unit) value /= 1024;
  char text[64];
  std::snprintf(text, sizeof(text), unit == 0 ? "%.0f %s" : "%.1f %s", value, units[unit]);
  return text;
}

}  // namespace gvx::app
