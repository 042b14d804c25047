#include "gvx/io/store_build.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "gvx/store/store_reader.h"
#include "gvx/store/verify.h"

namespace gvx::io {
namespace {

std::string temporary(const std::string& name) {
  return testing::TempDir() + "gvx_build_" + name;
}

/// A raw file of 20 x 10 x 7 samples value(i), i counting up.
template <typename Sample, typename Function>
std::string write_raw(const std::string& type, Function value) {
  const std::string path = temporary("20x10x7_" + type + ".raw");
  std::ofstream file(path, std::ios::binary);
  for (int i = 0; i < 1400; ++i) {
    const Sample sample = static_cast<Sample>(value(i));
    file.write(reinterpret_cast<const char*>(&sample), sizeof(sample));
  }
  return path;
}

Result<std::unique_ptr<store::StoreReader>> build(const std::string& input, const StoreBuildOptions& options,
                                                  StoreBuildReport* report = nullptr) {
  GVX_ASSIGN(const auto volume, open_volume(input, {}));
  const std::string path = temporary("out.gvx");
  GVX_ASSIGN(const auto made, build_store(exec::Device::cpu(), *volume, path, options, {}));
  if (report != nullptr) *report = made;
  GVX_TRY(store::verify(exec::Device::cpu(), path, {}).ok() ? Status{} : Status{Error{"does not verify"}});
  return store::StoreReader::open(path);
}

/// The physical value of finest voxel i.
double physical(const store::StoreReader& reader, int i) {
  const auto& info = reader.info();
  const std::uint32_t m = info.shape.m;
  const std::uint32_t x = static_cast<std::uint32_t>(i % 20), y = static_cast<std::uint32_t>(i / 20 % 10),
                      z = static_cast<std::uint32_t>(i / 200);
  const NodeKey key{info.shape.levels - 1, x / m, y / m, z / m};
  std::vector<std::byte> brick(info.brick_bytes());
  GVX_CHECK(reader.read_brick(key, reader.node(key).value(), brick).ok());
  const std::size_t texel = (x % m + 1) + (m + 2) * ((y % m + 1) + (m + 2) * std::size_t(z % m + 1));
  return with_voxel_type(info.format.type, [&](auto v) {
    std::memcpy(&v, &brick[texel * sizeof(v)], sizeof(v));
    return info.scale * static_cast<double>(v) + info.offset;
  });
}

template <typename Sample, typename Function>
void expect_exact(const std::string& type, VoxelType stored, Function value) {
  StoreBuildOptions options;
  options.m = 8;
  const auto reader = build(write_raw<Sample>(type, value), options);
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  EXPECT_EQ(reader.value()->info().format.type, stored);
  for (int i = 0; i < 1400; i += 13) {
    ASSERT_EQ(physical(*reader.value(), i), static_cast<double>(static_cast<Sample>(value(i))))
        << type << ' ' << i;
  }
}

TEST(StoreBuild, keeps_every_value_of_every_type_that_fits) {
  const auto ramp = [](int i) { return i % 256; };
  const auto signed_ramp = [](int i) { return i - 700; };
  expect_exact<std::uint8_t>("u8", VoxelType::u8, ramp);
  expect_exact<std::int8_t>("i8", VoxelType::u8, [](int i) { return i % 256 - 128; });
  expect_exact<std::uint16_t>("u16", VoxelType::u16, [](int i) { return i * 46; });
  expect_exact<std::int16_t>("i16", VoxelType::u16, signed_ramp);
  expect_exact<std::uint32_t>("u32", VoxelType::f32, [](int i) { return i * 1000; });
  expect_exact<std::int32_t>("i32", VoxelType::f32, signed_ramp);
  expect_exact<float>("f32", VoxelType::f32, [](int i) { return float(i) * 0.1f - 3; });
  expect_exact<double>("f64", VoxelType::f32, signed_ramp);
}

TEST(StoreBuild, quantises_to_a_narrower_type_over_the_whole_range) {
  StoreBuildOptions options;
  options.type = VoxelType::u8;
  const auto reader = build(write_raw<float>("f32", [](int i) { return -2 + 0.01 * i; }), options).value();
  EXPECT_EQ(reader->info().format.type, VoxelType::u8);
  EXPECT_EQ(reader->info().ranges.channel[0], (ValueRange{0, 255}));
  for (int i = 0; i < 1400; i += 7) EXPECT_NEAR(physical(*reader, i), -2 + 0.01 * i, 13.99 / 255 / 2 + 1e-5);
}

TEST(StoreBuild, stores_what_is_not_finite_as_zero_and_counts_it) {
  const auto value = [](int i) {
    return i % 100 == 0   ? std::numeric_limits<float>::quiet_NaN()
           : i % 100 == 1 ? -std::numeric_limits<float>::infinity()
                          : 5.0f;
  };
  StoreBuildReport report;
  const auto reader = build(write_raw<float>("f32", value), {}, &report).value();
  EXPECT_EQ(report.not_finite, 28u);
  EXPECT_EQ(physical(*reader, 100), 0);
  EXPECT_EQ(physical(*reader, 102), 5);
}

TEST(StoreBuild, says_how_much_memory_it_needs) {
  StoreBuildOptions options;
  options.memory_bytes = 1000;
  const auto reader = build(write_raw<std::uint8_t>("u8", [](int i) { return i; }), options);
  ASSERT_FALSE(reader.ok());
  EXPECT_NE(reader.error().message.find("--memory"), std::string::npos);
}

TEST(StoreBuild, an_input_that_ends_early_leaves_the_old_store) {
  const std::string output = temporary("out.gvx");
  ASSERT_TRUE(build(write_raw<std::uint8_t>("u8", [](int i) { return i; }), {}).ok());
  const auto size = std::filesystem::file_size(output);
  // Cut while packed, so that it shows only in the middle of the work.
  const std::string input = temporary("cut_20x10x7_u8.raw.gz");
  {
    const std::string raw = write_raw<std::uint8_t>("u8", [](int i) { return i * i * 31; });
    ASSERT_EQ(std::system(("gzip -c '" + raw + "' > '" + input + "'").c_str()), 0);
    std::filesystem::resize_file(input, std::filesystem::file_size(input) / 2);
  }
  const auto reader = build(input, {});
  ASSERT_FALSE(reader.ok());
  EXPECT_NE(reader.error().message.find(input), std::string::npos) << reader.error().message;
  EXPECT_EQ(std::filesystem::file_size(output), size);
  EXPECT_FALSE(std::filesystem::exists(output + ".partial"));
}

}  // namespace
}  // namespace gvx::io
