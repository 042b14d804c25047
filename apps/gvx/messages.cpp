#include "messages.h"

#include <algorithm>
#include <cstdio>

namespace gvx::app {

std::string one_line(std::string text) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  std::replace_if(text.begin(), text.end(), is_control, '?');
  return text;
}

void warn(const std::string& message) {
  std::fprintf(stderr, "gvx: %s\n", one_line(message).c_str());
}

}  // namespace gvx::app
