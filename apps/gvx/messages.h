/// \file
/// What the program says to people.
#pragma once

#include <string>

namespace gvx::app {

/// The text on one line: names of files may hold line ends and other control characters, which become '?'.
std::string one_line(std::string text);

/// "gvx: MESSAGE", one line on standard error.
void warn(const std::string& message);

}  // namespace gvx::app
