/// \file
/// DoubleDouble: a number as the sum of two doubles, good for about 31 decimal digits: places so deep in a
/// volume that one double cannot name them. Sums and products after Dekker (Numerische Mathematik 18, 1971)
/// and Knuth (TAOCP 2, 4.2.2). Host code.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "gvx/core/vec.h"

namespace gvx {

struct DoubleDouble {
  double high = 0, low = 0;  ///< low is at most half of high's last bit

  constexpr DoubleDouble() = default;
  constexpr DoubleDouble(double value) : high(value) {}
  constexpr DoubleDouble(double high_, double low_) : high(high_), low(low_) {}

  GVX_HD constexpr explicit operator double() const { return high; }
  constexpr bool operator==(const DoubleDouble&) const = default;
};

/// a + b without an error.
inline DoubleDouble two_sum(double a, double b) {
  const double sum = a + b, b_in = sum - a;
  return {sum, (a - (sum - b_in)) + (b - b_in)};
}

/// The same of numbers that do not overlap much, `a` the greater.
inline DoubleDouble normalized(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

inline DoubleDouble operator+(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble high = two_sum(a.high, b.high), low = two_sum(a.low, b.low);
  const DoubleDouble sum = normalized(high.high, high.low + low.high);
  return normalized(sum.high, sum.low + low.low);
}
inline DoubleDouble operator-(DoubleDouble a) {
  return {-a.high, -a.low};
}
inline DoubleDouble operator-(DoubleDouble a, DoubleDouble b) {
  return a + -b;
}
inline DoubleDouble operator*(DoubleDouble a, DoubleDouble b) {
  const double product = a.high * b.high, error = std::fma(a.high, b.high, -product);
  return normalized(product, error + (a.high * b.low + a.low * b.high));
}
inline DoubleDouble operator/(DoubleDouble a, DoubleDouble b) {
  DoubleDouble quotient = a.high / b.high;
  for (int digit = 0; digit < 2; ++digit) quotient = quotient + (a - quotient * b).high / b.high;
  return quotient;
}

/// The greatest whole number that is no greater.
inline DoubleDouble floor(DoubleDouble a) {
  const double high = std::floor(a.high);
  return high == a.high ? normalized(high, std::floor(a.low)) : DoubleDouble(high);
}

/// From decimal digits, with or without a fraction and an exponent; nothing where that is no finite number.
std::optional<DoubleDouble> parse_double_double(std::string_view text);

/// Decimal digits, up to 31 of them.
std::string to_text(DoubleDouble value);

using Vec3dd = Vec3<DoubleDouble>;

}  // namespace gvx
