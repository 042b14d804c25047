#include "gvx/io/volume_test_support.h"

#include <bzlib.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

namespace gvx::io::test {
namespace {

struct TemporaryFolder {
  TemporaryFolder() : path(testing::TempDir() + "gvx_io_" + std::to_string(getpid()) + "/") {
    std::filesystem::create_directories(path);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }

  std::string path;
};

}  // namespace

std::string temporary_path(const std::string& name) {
  static const TemporaryFolder folder;
  return folder.path + name;
}

std::string deflated(std::string_view bytes, int window_bits) {
  std::string packed(bytes.size() + 1024, '\0');
  z_stream state{};
  GVX_CHECK(deflateInit2(&state, 9, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) == Z_OK);
  state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  state.avail_in = static_cast<uInt>(bytes.size());
  state.next_out = reinterpret_cast<Bytef*>(packed.data());
  state.avail_out = static_cast<uInt>(packed.size());
  GVX_CHECK(deflate(&state, Z_FINISH) == Z_STREAM_END);
  packed.resize(state.total_out);
  deflateEnd(&state);
  return packed;
}

std::string bzipped(std::string_view bytes) {
  std::string packed(bytes.size() + 1024, '\0');
  auto size = static_cast<unsigned>(packed.size());
  GVX_CHECK(BZ2_bzBuffToBuffCompress(packed.data(), &size, const_cast<char*>(bytes.data()),
                                     static_cast<unsigned>(bytes.size()), 9, 0, 0) == BZ_OK);
  packed.resize(size);
  return packed;
}

}  // namespace gvx::io::test
