#include "gvx/io/store_build.h"

#include <array>
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

/// What is stored of finest voxel i.
double stored(const store::StoreReader& reader, int i) {
  const auto& info = reader.info();
  const std::uint32_t m = info.shape.m;
  const std::uint32_t x = static_cast<std::uint32_t>(i % 20), y = static_cast<std::uint32_t>(i / 20 % 10),
                      z = static_cast<std::uint32_t>(i / 200);
  const NodeKey key{info.shape.levels - 1, x / m, y / m, z / m};
  std::vector<std::byte> brick(info.brick_bytes());
  GVX_CHECK(reader.read_brick(key, reader.node(key).value(), brick).ok());
  constexpr std::uint32_t kBorder = kBrickBorder;
  const std::size_t edge = m + 2 * kBorder;
  const std::size_t texel = (x % m + kBorder) + edge * ((y % m + kBorder) + edge * (z % m + kBorder));
  return with_voxel_type(info.format.type, [&](auto v) {
    std::memcpy(&v, &brick[texel * sizeof(v)], sizeof(v));
    return static_cast<double>(v);
  });
}

/// The physical value of finest voxel i.
double physical(const store::StoreReader& reader, int i) {
  return reader.info().scale * stored(reader, i) + reader.info().offset;
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

/// Each voxel's value less `reference`, which doubles may not tell apart from it.
std::vector<double> stored_beside(const store::StoreReader& reader, double reference) {
  std::vector<double> values;
  for (int i = 0; i < 1400; ++i)
    values.push_back((reader.info().offset - reference) + reader.info().scale * stored(reader, i));
  return values;
}

TEST(StoreBuild, keeps_apart_what_is_close_and_far_from_0) {
  const auto expect_steps = [](const auto& reader, double reference, double step) {
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    const std::vector<double> values = stored_beside(*reader.value(), reference);
    for (int i = 0; i < 1400; ++i) ASSERT_EQ(values[std::size_t(i)], step * (i % 7)) << i;
  };
  StoreBuildReport report;
  const auto near_1e9 = [](int i) { return 1e9 + 0.5 * (i % 7); };
  expect_steps(build(write_raw<double>("f64", near_1e9), {}, &report), 1e9, 0.5);
  EXPECT_EQ(report.rounded, 0u);
  expect_steps(build(write_raw<double>("f64", [&](int i) { return -4e9 + 0.5 * (i % 7); }), {}), -4e9, 0.5);
  expect_steps(build(write_raw<std::int32_t>("i32", [](int i) { return 2000000000 + i % 7; }), {}), 2e9, 1);
  expect_steps(
      build(write_raw<std::uint32_t>("u32", [](int i) { return 4000000000u + unsigned(i % 7); }), {}), 4e9,
      1);
  const auto i64 = [](int i) { return -(std::int64_t{1} << 62) + i % 7; };
  expect_steps(build(write_raw<std::int64_t>("i64", i64), {}, &report), -0x1p62, 1);
  EXPECT_EQ(report.rounded, 0u);
  const auto u64 = [](int i) { return (std::uint64_t{1} << 63) + std::uint64_t(i % 7); };
  expect_steps(build(write_raw<std::uint64_t>("u64", u64), {}), 0x1p63, 1);

  StoreBuildOptions options;
  options.type = VoxelType::u16;
  const auto quantised = build(write_raw<std::int64_t>("i64", i64), options);
  expect_steps(quantised, -0x1p62, 1);
  const auto reader = build(write_raw<double>("f64", near_1e9), options).value();
  for (int i = 0; i < 1400; i += 13) EXPECT_NEAR(physical(*reader, i), near_1e9(i), 1e-4);
}

TEST(StoreBuild, keeps_apart_what_is_close_and_far_from_a_background_of_0) {
  StoreBuildReport report;
  const auto value = [](int i) { return i % 2 == 0 ? 0 : 1e9 + 0.5 * (i % 7); };
  const auto reader = build(write_raw<double>("f64", value), {}, &report).value();
  EXPECT_EQ(report.rounded, 0u);
  for (int i = 0; i < 1400; ++i) ASSERT_EQ(physical(*reader, i), value(i)) << i;
}

TEST(StoreBuild, keeps_doubles_that_are_beyond_floats) {
  for (const double unit : {1e-300, 1e300}) {
    StoreBuildReport report;
    const auto reader = build(write_raw<double>("f64", [&](int i) { return unit * (i % 7); }), {}, &report);
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    EXPECT_EQ(report.not_finite, 0u);
    EXPECT_EQ(report.clamped, 0u);
    for (int i = 0; i < 1400; ++i)
      ASSERT_NEAR(physical(*reader.value(), i) / unit, i % 7, 1e-6) << i << ' ' << unit;
  }
}

TEST(StoreBuild, says_how_many_digits_rounded_samples_keep) {
  StoreBuildReport report;
  ASSERT_TRUE(
      build(write_raw<double>("f64", [](int i) { return i < 1000 ? 0.1 * (i % 50) : 7; }), {}, &report).ok());
  EXPECT_EQ(report.digits, 7);
  const auto lines = report.warnings("a.nii", SampleType::f64);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0],
            "a.nii: " + std::to_string(report.rounded) + " f64 samples are rounded to 7 significant digits");
  EXPECT_GT(report.rounded, 700u);
  EXPECT_LT(report.rounded, 1000u);
  ASSERT_TRUE(build(write_raw<double>("f64", [](int i) { return 0.25 * i; }), {}, &report).ok());
  EXPECT_TRUE(report.warnings("a.nii", SampleType::f64).empty());
}

TEST(StoreBuild, wide_labels_keep_their_numbers_or_are_refused) {
  StoreBuildOptions options;
  options.labels = true;
  const auto expect_labels = [&](const auto& reader, VoxelType type, int step) {
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    EXPECT_EQ(reader.value()->info().format, (VoxelFormat{type, VoxelContent::labels, 1}));
    for (int i = 0; i < 1400; i += 13) ASSERT_EQ(physical(*reader.value(), i), step * (i % 200)) << i;
  };
  expect_labels(build(write_raw<std::uint32_t>("u32", [](int i) { return i % 200; }), options), VoxelType::u8,
                1);
  expect_labels(build(write_raw<std::int32_t>("i32", [](int i) { return 300 * (i % 200); }), options),
                VoxelType::u16, 300);
  expect_labels(build(write_raw<std::int64_t>("i64", [](int i) { return 300 * (i % 200); }), options),
                VoxelType::u16, 300);
  expect_labels(build(write_raw<std::uint64_t>("u64", [](int i) { return i % 200; }), options), VoxelType::u8,
                1);
  const auto error_of = [&](const std::string& input) { return build(input, options).error().message; };
  const auto greatest = [](int i) { return i == 777 ? ~std::uint64_t{0} : 1; };
  EXPECT_NE(error_of(write_raw<std::uint64_t>("u64", greatest))
                .find("labels: expected 0 to 65535, found 18446744073709551615"),
            std::string::npos);
  EXPECT_NE(
      error_of(write_raw<std::int32_t>("i32", [](int i) { return i == 5 ? 65536 : i; })).find("found 65536"),
      std::string::npos);
  EXPECT_NE(error_of(write_raw<std::int32_t>("i32", [](int i) { return i - 3; })).find("found -3"),
            std::string::npos);
  EXPECT_NE(error_of(write_raw<std::int8_t>("i8", [](int i) { return i % 9 - 4; }))
                .find("labels: expected 0 to 255, found -4"),
            std::string::npos);
  expect_labels(build(write_raw<float>("f32", [](int i) { return 300 * (i % 200); }), options),
                VoxelType::u16, 300);
  expect_labels(build(write_raw<double>("f64", [](int i) { return i % 200; }), options), VoxelType::u8, 1);
  EXPECT_NE(error_of(write_raw<float>("f32", [](int i) { return i == 9 ? 2.5f : 1; }))
                .find("labels: expected whole numbers, found 2.5"),
            std::string::npos);
  EXPECT_NE(
      error_of(write_raw<float>("f32", [](int i) { return i == 9 ? 1e30f : 1; })).find("found 1.0000000"),
      std::string::npos);
}

/// A NIfTI file of 1400 samples value(i) of u8 or i16.
template <typename Sample, typename Function>
std::string write_nifti(float slope, float intercept, Function value) {
  const std::string path = temporary("labels.nii");
  std::string bytes(352, '\0');
  const auto put = [&](std::size_t at, auto number) { std::memcpy(&bytes[at], &number, sizeof(number)); };
  put(0, std::int32_t{348});
  constexpr std::array<std::int16_t, 4> kDimensions = {3, 20, 10, 7};
  for (std::size_t i = 0; i < 4; ++i) put(40 + 2 * i, kDimensions[i]);
  put(70, static_cast<std::int16_t>(sizeof(Sample) == 1 ? 2 : 4));
  put(72, static_cast<std::int16_t>(8 * sizeof(Sample)));
  for (std::size_t i = 0; i < 4; ++i) put(76 + 4 * i, 1.0f);
  put(108, 352.0f);
  put(112, slope);
  put(116, intercept);
  std::memcpy(&bytes[344], "n+1", 4);
  for (int i = 0; i < 1400; ++i) {
    const auto sample = static_cast<Sample>(value(i));
    bytes.append(reinterpret_cast<const char*>(&sample), sizeof(sample));
  }
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

TEST(StoreBuild, labels_are_physical_values) {
  StoreBuildOptions options;
  options.labels = true;
  const auto expect_labels = [&](const std::string& input, VoxelType type, int step, int first) {
    const auto reader = build(input, options);
    ASSERT_TRUE(reader.ok()) << reader.error().message;
    EXPECT_EQ(reader.value()->info().format, (VoxelFormat{type, VoxelContent::labels, 1}));
    EXPECT_EQ(reader.value()->info().scale, 1);
    EXPECT_EQ(reader.value()->info().offset, 0);
    for (int i = 0; i < 1400; i += 13) ASSERT_EQ(stored(*reader.value(), i), step * (i % 100) + first) << i;
  };
  const auto ramp = [](int i) { return i % 100; };
  expect_labels(write_nifti<std::uint8_t>(2, 5, ramp), VoxelType::u8, 2, 5);
  expect_labels(write_nifti<std::uint8_t>(300, 0, ramp), VoxelType::u16, 300, 0);
  expect_labels(write_nifti<std::int16_t>(1, 1024, [](int i) { return i % 100 - 1024; }), VoxelType::u8, 1,
                0);
  // 0.1 is no float.
  expect_labels(write_nifti<std::int16_t>(0.1f, 0, [](int i) { return 10 * (i % 100); }), VoxelType::u8, 1,
                0);
  const auto expect_error = [&](const std::string& input, const std::string& part) {
    const auto reader = build(input, options);
    ASSERT_FALSE(reader.ok());
    EXPECT_NE(reader.error().message.find(part), std::string::npos) << reader.error().message;
  };
  expect_error(write_nifti<std::uint8_t>(2, -5, ramp), "labels: expected 0 to 65535, found -5");
  expect_error(write_nifti<std::uint8_t>(1, -1024, ramp), "labels: expected 0 to 65535, found -1024");
  expect_error(write_nifti<std::uint8_t>(0.5f, 0, [](int i) { return i == 7 ? 3 : 2; }),
               "labels: expected whole numbers, found 1.5");
  expect_error(write_nifti<std::uint8_t>(3e35f, 0, ramp), "labels: expected 0 to 65535, found ");
}

TEST(StoreBuild, quantises_to_a_narrower_type_over_the_whole_range) {
  StoreBuildOptions options;
  options.type = VoxelType::u8;
  const auto reader = build(write_raw<float>("f32", [](int i) { return -2 + 0.01 * i; }), options).value();
  EXPECT_EQ(reader->info().format.type, VoxelType::u8);
  EXPECT_EQ(reader->info().ranges.channel[0], (ValueRange{0, 255}));
  for (int i = 0; i < 1400; i += 7) EXPECT_NEAR(physical(*reader, i), -2 + 0.01 * i, 13.99 / 255 / 2 + 1e-5);
}

TEST(StoreBuild, integers_of_a_narrow_range_stay_whole) {
  StoreBuildOptions options;
  options.type = VoxelType::u8;
  const auto value = [](int i) { return 70000 + i % 200; };
  const auto reader = build(write_raw<std::int32_t>("i32", value), options).value();
  EXPECT_EQ(reader->info().format.type, VoxelType::u8);
  for (int i = 0; i < 1400; i += 7) EXPECT_EQ(physical(*reader, i), value(i));
}

TEST(StoreBuild, what_is_not_finite_is_no_data_and_counted) {
  const auto value = [](int i) {
    return i % 100 == 0   ? std::numeric_limits<float>::quiet_NaN()
           : i % 100 == 1 ? -std::numeric_limits<float>::infinity()
                          : 5.0f;
  };
  StoreBuildReport report;
  const auto reader = build(write_raw<float>("f32", value), {}, &report).value();
  EXPECT_EQ(report.not_finite, 28u);
  EXPECT_EQ(report.infinite, 14u);
  EXPECT_TRUE(reader->info().no_data);
  EXPECT_EQ(reader->info().ranges.channel[0], (ValueRange{5, 5}));
  EXPECT_TRUE(std::isnan(physical(*reader, 100)));
  EXPECT_TRUE(std::isnan(physical(*reader, 101)));
  EXPECT_EQ(physical(*reader, 102), 5);
  EXPECT_EQ(report.warnings("a.nii", SampleType::f32)[0],
            "a.nii: 28 voxels have no value (NaN or infinite): shown as transparent");
}

TEST(StoreBuild, no_data_is_the_least_value_of_a_narrower_type) {
  StoreBuildOptions options;
  options.type = VoxelType::u8;
  StoreBuildReport report;
  const auto value = [](int i) { return i % 100 == 0 ? std::nan("") : -10 + i % 6; };
  const auto reader = build(write_raw<double>("f64", value), options, &report).value();
  EXPECT_FALSE(reader->info().no_data);
  EXPECT_EQ(physical(*reader, 100), -10);
  EXPECT_NEAR(physical(*reader, 101), value(101), 0.02);
  EXPECT_EQ(report.warnings("a.nii", SampleType::f64)[0],
            "a.nii: 14 voxels have no value (NaN): stored as the least value, -10; with --type f32 they are "
            "transparent");
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

TEST(StoreBuild, what_a_caller_gets_wrong_is_an_error) {
  const std::string path = write_raw<std::uint8_t>("u8", [](int i) { return i % 200; });
  EXPECT_NE(build(path, {.n = 1}).error().message.find("expected 2 or 3"), std::string::npos);
  EXPECT_NE(build(path, {.m = 12}).error().message.find("expected 8, 16 or 32"), std::string::npos);
  const auto volume = open_volume(path, {}).value();
  std::vector<std::byte> slice(slice_bytes(volume->description()));
  ASSERT_TRUE(volume->read_slices(1, slice).ok());
  const auto late = build_store(exec::Device::cpu(), *volume, temporary("late.gvx"), {}, {});
  ASSERT_FALSE(late.ok());
  EXPECT_NE(late.error().message.find("rewind() it"), std::string::npos) << late.error().message;
}

}  // namespace
}  // namespace gvx::io
