#include "gvx/core/text_file.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace gvx {
namespace {

TEST(TextFile, is_read_whole_or_not_at_all) {
  const std::string path = testing::TempDir() + "gvx_text_file";
  std::filesystem::remove(path);
  EXPECT_NE(read_text_file(path, "a poem").error().message.find(path + ": cannot open: "), std::string::npos);
  std::string text(kLargestTextFile, 'x');
  text[7] = '\0';
  std::ofstream(path, std::ios::binary) << text;
  EXPECT_EQ(read_text_file(path, "a poem").value(), text);
  std::ofstream(path, std::ios::binary | std::ios::app) << 'y';
  EXPECT_EQ(read_text_file(path, "a poem").error().message, path + ": larger than a poem can be (16 MiB)");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace gvx
