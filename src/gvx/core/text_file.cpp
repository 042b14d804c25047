#include "gvx/core/text_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

namespace gvx {

Result<std::string> read_text_file(const std::string& path, const char* what) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path + ": cannot open: " + std::strerror(errno)};
  std::string text(kLargestTextFile + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return Error{path + ": cannot read"};
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kLargestTextFile) return Error{path + ": larger than " + what + " can be (16 MiB)"};
  return text;
}

}  // namespace gvx
