#include "gvx/core/partial_file.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

namespace gvx {
namespace {

namespace fs = std::filesystem;

class PartialFiles : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string content(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void put(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  Status write(const std::string& file, const std::string& text) const {
    GVX_ASSIGN(PartialFile partial, PartialFile::create(file));
    GVX_TRY(partial.write(std::as_bytes(std::span(text))));
    return partial.commit();
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }

  fs::path folder_ = fs::path(testing::TempDir()) / "gvx_partial_file";
};

TEST_F(PartialFiles, links_stay_and_what_they_name_is_replaced) {
  fs::create_directories(path("elsewhere"));
  put("elsewhere/target", "before");
  fs::create_symlink("elsewhere/target", path("link"));
  fs::create_symlink("link", path("link_to_link"));
  ASSERT_TRUE(write(path("link_to_link"), "after").ok());
  EXPECT_EQ(content("elsewhere/target"), "after");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_TRUE(fs::is_symlink(path("link_to_link")));
  fs::create_symlink("elsewhere/new", path("dangling"));
  ASSERT_TRUE(write(path("dangling"), "made").ok());
  EXPECT_EQ(content("elsewhere/new"), "made");
  EXPECT_TRUE(fs::is_symlink(path("dangling")));
  fs::create_symlink("round", path("round"));
  EXPECT_FALSE(write(path("round"), "").ok());
  fs::create_symlink(path("no/such/file"), path("astray"));
  EXPECT_FALSE(write(path("astray"), "").ok());
}

TEST_F(PartialFiles, permissions_of_what_is_replaced_are_kept) {
  put("secret", "before");
  ::chmod(path("secret").c_str(), 0640);
  ASSERT_TRUE(write(path("secret"), "after").ok());
  struct stat status {};
  ASSERT_EQ(::stat(path("secret").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0640u);
}

TEST_F(PartialFiles, pipes_and_devices_are_written_to) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  std::string received;
  std::thread reader([&] {
    std::ifstream pipe(path("pipe"));
    received.assign(std::istreambuf_iterator<char>(pipe), {});
  });
  EXPECT_TRUE(write(path("pipe"), "through the pipe").ok());
  reader.join();
  EXPECT_EQ(received, "through the pipe");
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
  fs::create_symlink("/dev/null", path("null"));
  EXPECT_TRUE(write(path("null"), "nowhere").ok());
  EXPECT_TRUE(fs::is_symlink(path("null")));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  if (fs::exists("/dev/full")) {
    fs::create_symlink("/dev/full", path("full"));
    EXPECT_FALSE(write(path("full"), "too much").ok());
  }
  // A link of that name would take the device's place.
  EXPECT_FALSE(fs::exists("/dev/null.partial"));
}

TEST_F(PartialFiles, descriptors_of_this_process_are_written_to) {
  const int descriptor = ::open(path("open").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_GE(descriptor, 0);
  ASSERT_EQ(::write(descriptor, "first ", 6), 6);
  for (const std::string folder : {"/dev/fd/", "/proc/self/fd/"}) {
    EXPECT_TRUE(write(folder + std::to_string(descriptor), "then ").ok());
  }
  EXPECT_EQ(content("open"), "first then then ");
  fs::create_symlink("/dev/fd/" + std::to_string(descriptor), path("link"));
  EXPECT_TRUE(write(path("link"), "last").ok());
  EXPECT_EQ(content("open"), "first then then last");
  ::close(descriptor);
  EXPECT_FALSE(write("/dev/fd/" + std::to_string(descriptor), "").ok());
}

TEST_F(PartialFiles, what_cannot_be_written_is_found_before) {
  EXPECT_TRUE(check_writable(path("new")).ok());
  EXPECT_TRUE(check_writable("/dev/null").ok());
  for (const std::string bad : {"", "no/such/folder/file", "new/"}) {
    const Status status = check_writable(bad.empty() ? folder_.string() : path(bad));
    ASSERT_FALSE(status.ok()) << bad;
    EXPECT_NE(status.error().message.find("cannot create"), std::string::npos) << status.error().message;
  }
  EXPECT_EQ(files(), 0u);
  if (::geteuid() == 0) return;
  put("protected", "");
  ::chmod(path("protected").c_str(), 0444);
  EXPECT_FALSE(check_writable(path("protected")).ok());
  EXPECT_FALSE(check_writable("/proc/new").ok());
}

TEST_F(PartialFiles, two_do_not_write_one_file) {
  const auto first = PartialFile::create(path("file"));
  ASSERT_TRUE(first.ok());
  const auto second = PartialFile::create(path("file"));
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find("another"), std::string::npos);
  EXPECT_TRUE(fs::exists(path("file.partial")));
}

TEST_F(PartialFiles, all_can_be_removed_before_the_program_ends) {
  // In a process of its own: nothing can be made afterwards.
  const auto removed = [&] {
    const auto file = PartialFile::create(path("a")), other = PartialFile::create(path("b"));
    if (!file.ok() || !other.ok() || files() != 2) std::_Exit(1);
    remove_partial_files();
    std::_Exit(files() == 0 ? 0 : 2);
  };
  EXPECT_EXIT(removed(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace gvx
