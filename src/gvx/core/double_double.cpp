#include "gvx/core/double_double.h"

#include <algorithm>
#include <charconv>

namespace gvx {
namespace {

DoubleDouble power_of_ten(int exponent) {
  DoubleDouble power = 1;
  for (int i = 0; i < exponent; ++i) power = power * 10;
  return power;
}

/// Takes a number without a sign off the front of a text.
std::optional<DoubleDouble> take_number(std::string_view& text) {
  constexpr int kMostDigits = 40;  // more than count
  constexpr int kMostExponent = 300;
  DoubleDouble value;
  int digits = 0, shift = 0;
  bool fraction = false, any = false;
  for (; !text.empty() && (text[0] == '.' || (text[0] >= '0' && text[0] <= '9')); text.remove_prefix(1)) {
    if (text[0] == '.') {
      if (fraction) return std::nullopt;
      fraction = true;
      continue;
    }
    any = true;
    const bool counts = digits < kMostDigits;
    if (counts) value = value * 10 + double(text[0] - '0');
    if (counts && (digits > 0 || text[0] != '0')) ++digits;
    shift += (counts ? 0 : 1) - (fraction ? 1 : 0);
  }
  if (!any) return std::nullopt;
  if (!text.empty() && (text[0] == 'e' || text[0] == 'E')) {
    int exponent = 0;
    text.remove_prefix(text.size() > 1 && text[1] == '+' ? 2 : 1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), exponent);
    if (error != std::errc{} || exponent < -kMostExponent || exponent > kMostExponent) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    shift += exponent;
  }
  if (shift < -2 * kMostExponent || shift > kMostExponent) return std::nullopt;
  if (shift < -kMostExponent) value = value / power_of_ten(kMostExponent), shift += kMostExponent;
  return shift < 0 ? value / power_of_ten(-shift) : value * power_of_ten(shift);
}

}  // namespace

std::optional<DoubleDouble> parse_double_double(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const auto number = take_number(text);
  if (!number || !text.empty() || !std::isfinite(number->high)) return std::nullopt;
  return negative ? -*number : *number;
}

std::string to_text(DoubleDouble value) {
  if (value.high == 0) return "0";
  constexpr int kDigits = 31;
  DoubleDouble rest = value.high < 0 ? -value : value;
  int exponent = static_cast<int>(std::floor(std::log10(rest.high)));
  // To a whole number of that many digits, or one more or fewer.
  const int shift = kDigits - 1 - exponent;
  rest = shift < 0 ? rest / power_of_ten(-shift) : rest * power_of_ten(shift);
  rest = floor(rest + 0.5);
  std::string digits;
  while (rest.high > 0) {
    const DoubleDouble tenth = floor(rest / 10);
    const double digit = (rest - tenth * 10).high;
    digits.insert(digits.begin(), static_cast<char>('0' + std::clamp(static_cast<int>(digit), 0, 9)));
    rest = tenth;
  }
  exponent = static_cast<int>(digits.size()) - 1 - shift;
  digits.erase(digits.find_last_not_of('0') + 1);
  const auto count = static_cast<int>(digits.size());
  constexpr int kMostZeros = 5;
  const int before_point = exponent + 1;
  if (exponent < -kMostZeros || exponent >= kDigits) {
    if (count > 1) digits.insert(1, 1, '.');
    digits += 'e' + std::to_string(exponent);
  } else if (exponent < 0) {
    digits.insert(0, "0." + std::string(static_cast<std::size_t>(-exponent - 1), '0'));
  } else if (count <= exponent) {
    digits.append(static_cast<std::size_t>(exponent + 1 - count), '0');
  } else if (count > exponent + 1) {
    digits.insert(static_cast<std::size_t>(before_point), 1, '.');
  }
  return (value.high < 0 ? "-" : "") + digits;
}

}  // namespace gvx
