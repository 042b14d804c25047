/// \file
/// The small tools that parsers of text headers share. Text comes from strangers: lengths are bounded,
/// nothing is trusted to be printable, and numbers are parsed in the C locale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gvx/core/result.h"

namespace gvx::io {

/// No header of a format that gvx reads is longer; a file that claims one is refused.
inline constexpr std::size_t kMaximumHeaderBytes = std::size_t{1} << 20;

/// "PATH: MESSAGE".
Error file_error(const std::string& path, const std::string& message);

/// The text in quotation marks, shortened to about 60 characters, unprintable ones replaced: fit for one
/// line.
std::string quoted(std::string_view text);

/// Without white space at either end.
std::string_view trimmed(std::string_view text);

/// ASCII letters made small; other bytes are kept.
std::string lower_case(std::string_view text);

/// The parts between white space.
std::vector<std::string_view> words(std::string_view text);

/// The whole text as a decimal integer; nothing where it is not one or does not fit.
std::optional<std::int64_t> parse_integer(std::string_view text);

/// The whole text as a number, "nan" and "inf" included; nothing where it is not one.
std::optional<double> parse_number(std::string_view text);

/// As few digits as tell the number from all others: "1000000000", "0.1", "1e-12", "nan".
std::string number_text(double number);

/// Every word as a number; nothing where one is not.
std::optional<std::vector<double>> parse_numbers(std::string_view text);

/// The first kMaximumHeaderBytes of a file, or all of a shorter one.
Result<std::string> read_file_start(const std::string& path);

/// Takes the first line off `rest`, with its end ("\n" or "\r\n") removed from what is returned.
std::string_view take_line(std::string_view& rest);

/// `name` seen from the folder of the header file; an absolute name is kept.
std::string beside(const std::string& header_path, std::string_view name);

}  // namespace gvx::io
