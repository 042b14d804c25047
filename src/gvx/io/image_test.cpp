#include "gvx/io/image.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "gvx/io/file_commit.h"
#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {
namespace {

std::vector<std::uint8_t> pattern(std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint8_t> rgba(std::size_t{4} * width * height);
  for (std::size_t i = 0; i < rgba.size(); ++i) rgba[i] = static_cast<std::uint8_t>(i * 37 + i / 256);
  return rgba;
}

TEST(PngImage, comes_back_as_it_was_written) {
  const std::string path = temporary_path("picture.png");
  for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 3u}, {300u, 200u}}) {
    const std::vector<std::uint8_t> rgba = pattern(width, height);
    const Status written = write_png(path, width, height, rgba);
    ASSERT_TRUE(written.ok()) << outcome(written);
    const auto image = read_png(path);
    ASSERT_TRUE(image.ok()) << outcome(image);
    EXPECT_EQ(image.value().width, width);
    EXPECT_EQ(image.value().height, height);
    EXPECT_EQ(image.value().rgba, rgba);
    EXPECT_FALSE(std::filesystem::exists(path + ".partial"));
  }
}

TEST(PngImage, wrong_sizes_are_errors) {
  const std::string path = temporary_path("wrong.png");
  std::filesystem::remove(path);
  const std::vector<std::uint8_t> rgba = pattern(2, 2);
  EXPECT_NE(outcome(write_png(path, 0, 2, {})).find("size: expected"), std::string::npos);
  EXPECT_NE(outcome(write_png(path, 3, 2, rgba)).find("samples: expected 24, found 16"), std::string::npos);
  EXPECT_NE(outcome(write_png(path, 0xffffffffu, 0xffffffffu, rgba)).find("size: expected"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(PngImage, every_truncation_is_an_error_or_the_picture) {
  const std::string whole = temporary_path("whole.png"), cut = temporary_path("cut.png");
  ASSERT_TRUE(write_png(whole, 7, 3, pattern(7, 3)).ok());
  const std::string bytes = read_file(whole);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    write_file(cut, bytes.substr(0, size));
    const auto image = read_png(cut);
    if (image.ok()) {
      EXPECT_EQ(image.value().rgba, pattern(7, 3)) << size;
    } else {
      EXPECT_EQ(image.error().message.rfind(cut, 0), 0u) << image.error().message;
    }
  }
}

TEST(PngImage, a_huge_claim_is_refused_before_memory_is_taken) {
  const std::string path = temporary_path("huge.png");
  ASSERT_TRUE(write_png(path, 7, 3, pattern(7, 3)).ok());
  std::string bytes = read_file(path);
  bytes.replace(16, 8, std::string("\x00\x0f\x00\x00\x00\x0f\x00\x00", 8));
  write_file(path, bytes);
  EXPECT_FALSE(read_png(path).ok());
}

TEST(ExrImage, is_written_or_says_that_it_cannot) {
  const std::string path = temporary_path("picture.exr");
  std::filesystem::remove(path);
  const std::vector<float> rgba(4 * 6 * 5, 0.25f);
  const Status written = write_exr(path, 6, 5, rgba);
  EXPECT_FALSE(std::filesystem::exists(path + ".partial"));
  if (!written.ok()) {
    EXPECT_EQ(outcome(written), path + ": cannot write EXR: this gvx was built without OpenEXR");
    GTEST_SKIP() << "built without OpenEXR";
  }
  EXPECT_EQ(read_file(path).substr(0, 4), "\x76\x2f\x31\x01");
  EXPECT_FALSE(write_exr(path, 6, 4, rgba).ok());
}

TEST(FileCommit, failures_leave_nothing_and_keep_what_was_there) {
  const std::string nowhere = temporary_path("no_such_folder/picture.png");
  EXPECT_NE(outcome(write_png(nowhere, 1, 1, pattern(1, 1))).find("cannot create"), std::string::npos);

  const std::string folder = temporary_path("folder");
  std::filesystem::create_directories(folder + "/inside");
  EXPECT_FALSE(write_png(folder, 1, 1, pattern(1, 1)).ok());
  EXPECT_FALSE(std::filesystem::exists(folder + ".partial"));

  const std::string kept = temporary_path("kept.txt");
  write_file(kept, "before");
  {
    auto file = PartialFile::create(kept);
    ASSERT_TRUE(file.ok()) << outcome(file);
    ASSERT_TRUE(file.value().write(std::as_bytes(std::span("after"))).ok());
    EXPECT_TRUE(std::filesystem::exists(kept + ".partial"));
  }
  EXPECT_FALSE(std::filesystem::exists(kept + ".partial"));
  EXPECT_EQ(read_file(kept), "before");
  ASSERT_TRUE(write_file_atomically(kept, std::as_bytes(std::span("after", 5))).ok());
  EXPECT_EQ(read_file(kept), "after");
}

TEST(FileCommit, a_full_disk_is_an_error) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  const std::string path = temporary_path("full.png");
  std::filesystem::remove(path);
  std::filesystem::remove(path + ".partial");
  std::filesystem::create_symlink("/dev/full", path + ".partial");
  EXPECT_NE(outcome(write_png(path, 2, 2, pattern(2, 2))).find("cannot write"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::is_symlink(path + ".partial"));
}

}  // namespace
}  // namespace gvx::io::test
