#include "messages.h"

#include <algorithm>
#include <cstdio>

#include <unistd.h>

namespace gvx::app {

std::string one_line(std::string text) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::replace_if(text.begin(), text.end(), is_control, '?');
  return text;
}

void warn(const std::string& message) {
  // A bar of progress may stand there.
  const char* clear = isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "";
  std::fprintf(stderr, "%sgvx: %s\n", clear, one_line(message).c_str());
}

}  // namespace gvx::app
