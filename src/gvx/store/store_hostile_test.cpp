// Stores that are cut, damaged or made up: an error that names the file, never a crash, never a wrong voxel
// in silence.

#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "gvx/store/store_reader.h"
#include "gvx/store/store_test_support.h"
#include "gvx/store/verify.h"

namespace gvx::store {
namespace {

class HostileStore : public testing::Test {
 protected:
  void SetUp() override {
    const TestVolume<std::uint8_t> volume({40, 30, 20}, [](auto x, auto y, auto z) { return x * y + z * 3; });
    ASSERT_TRUE(write_store(volume, path_, 2, 8).ok());
    std::ifstream file(path_, std::ios::binary);
    good_.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }

  /// Verifies a store of these bytes.
  Result<VerifyReport> verify_bytes(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), std::streamsize(bytes.size()));
    return verify(exec::Device::cpu(1), path_, {});
  }

  std::string path_ = testing::TempDir() + "gvx_hostile.gvx";
  std::string good_;
};

TEST_F(HostileStore, every_truncation_is_an_error_that_names_the_file) {
  for (std::size_t length = 0; length < good_.size(); length += length < 600 ? 1 : 97) {
    const auto report = verify_bytes(good_.substr(0, length));
    ASSERT_FALSE(report.ok()) << length;
    ASSERT_NE(report.error().message.find(path_), std::string::npos);
    ASSERT_EQ(report.error().message.find('\n'), std::string::npos);
  }
}

TEST_F(HostileStore, every_flipped_byte_is_found) {
  ASSERT_TRUE(verify_bytes(good_).ok());
  for (std::size_t i = 0; i < good_.size(); i += i < 256 ? 1 : 61) {
    std::string bad = good_;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    ASSERT_FALSE(verify_bytes(bad).ok()) << "byte " << i;
  }
}

TEST_F(HostileStore, a_made_up_header_with_a_right_checksum_does_no_harm) {
  std::mt19937 random(11);
  int opened = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string bad = good_;
    FileHeader header;
    std::memcpy(&header, bad.data(), sizeof(header));
    auto* bytes = reinterpret_cast<unsigned char*>(&header);
    for (int k = 0; k < 1 + i % 3; ++k)
      bytes[12 + random() % (sizeof(header) - 20)] = static_cast<unsigned char>(random());
    const auto span = std::as_bytes(std::span(&header, 1));
    header.header_checksum = checksum(span.first(offsetof(FileHeader, header_checksum)));
    std::memcpy(bad.data(), &header, sizeof(header));
    opened += verify_bytes(bad).ok() ? 1 : 0;
  }
  // Most fields matter; those that only place and scale the volume leave its voxels sound.
  EXPECT_LT(opened, 2500);
}

TEST_F(HostileStore, a_placement_that_no_ray_can_cross_is_an_error) {
  for (const double scale : {0.0, 1e-200, 1e150, 1e308, -1e-9}) {
    std::string bad = good_;
    FileHeader header;
    std::memcpy(&header, bad.data(), sizeof(header));
    header.voxel_to_world[0] = scale;
    const auto span = std::as_bytes(std::span(&header, 1));
    header.header_checksum = checksum(span.first(offsetof(FileHeader, header_checksum)));
    std::memcpy(bad.data(), &header, sizeof(header));
    EXPECT_FALSE(verify_bytes(bad).ok()) << scale;
  }
}

TEST_F(HostileStore, dimensions_whose_pages_overflow_are_an_error) {
  std::string bad = good_;
  FileHeader header;
  std::memcpy(&header, bad.data(), sizeof(header));
  for (std::uint64_t& d : header.dimensions) d = 0x7fffffff;
  header.levels = TreeShape::covering({0x7fffffff, 0x7fffffff, 0x7fffffff}, header.n, header.m).levels;
  const auto span = std::as_bytes(std::span(&header, 1));
  header.header_checksum = checksum(span.first(offsetof(FileHeader, header_checksum)));
  std::memcpy(bad.data(), &header, sizeof(header));
  const auto report = verify_bytes(bad);
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().message.find("directory size"), std::string::npos) << report.error().message;
}

TEST_F(HostileStore, what_is_no_store_is_an_error) {
  EXPECT_FALSE(StoreReader::open("/no/such/file.gvx").ok());
  EXPECT_FALSE(StoreReader::open(testing::TempDir()).ok());
  EXPECT_FALSE(verify_bytes("").ok());
  EXPECT_FALSE(verify_bytes(std::string(5000, 'x')).ok());
  std::string version = good_;
  version[8] = 9;
  EXPECT_NE(verify_bytes(version).error().message.find("version 9"), std::string::npos);
}

}  // namespace
}  // namespace gvx::store
