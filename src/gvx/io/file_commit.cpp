#include "gvx/io/file_commit.h"

namespace gvx::io {

Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  GVX_ASSIGN(PartialFile file, PartialFile::create(path));
  GVX_TRY(file.write(bytes));
  return file.commit();
}

}  // namespace gvx::io
