#include "gvx/io/raw.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {
namespace {

constexpr int kGzip = 15 + 16;

TEST(RawVolume, every_sample_type_in_both_byte_orders) {
  for (const SampleType type : kAllSampleTypes) {
    for (const bool big_endian : {false, true}) {
      const std::string path =
          temporary_path(std::string("v_4x3x2_") + sample_name(type) + (big_endian ? "_be" : "") + ".raw");
      write_file(path, small_samples(type, big_endian));
      const auto samples = load(path);
      ASSERT_TRUE(samples.ok()) << outcome(samples);
      EXPECT_EQ(samples.value(), native_small_samples(type)) << path;
    }
  }
}

TEST(RawVolume, slices_come_in_any_grouping_and_again_after_rewind) {
  const std::string path = temporary_path("v_4x3x2_u16.raw");
  write_file(path, small_samples(SampleType::u16, false));
  const auto reader = open_volume(path, {});
  ASSERT_TRUE(reader.ok()) << outcome(reader);
  for (const std::int64_t step : {1, 2}) {
    const auto samples = read_all(*reader.value(), step);
    ASSERT_TRUE(samples.ok()) << outcome(samples);
    EXPECT_EQ(samples.value(), native_small_samples(SampleType::u16));
    EXPECT_EQ(reader.value()->next_slice(), 2);
    ASSERT_TRUE(reader.value()->rewind().ok());
  }
}

TEST(RawVolume, slices_that_are_not_left_and_memory_of_another_size_are_errors) {
  const std::string path = temporary_path("v_4x3x2_u16.raw");
  write_file(path, small_samples(SampleType::u16, false));
  const auto reader = open_volume(path, {}).value();
  std::vector<std::byte> memory(3 * slice_bytes(reader->description()));
  const auto expect = [&](std::int64_t count, std::size_t bytes, const char* what) {
    const Status status = reader->read_slices(count, std::span(memory).first(bytes));
    ASSERT_FALSE(status.ok()) << what;
    EXPECT_NE(status.error().message.find(what), std::string::npos) << status.error().message;
  };
  expect(3, 72, "3 slices, of which 2 are left");
  expect(-1, 0, "-1 slices");
  expect(1, 23, "memory of 23 bytes for 1 slices; expected 24");
  EXPECT_EQ(reader->next_slice(), 0);
  ASSERT_TRUE(reader->read_slices(2, std::span(memory).first(48)).ok());
  expect(1, 24, "of which 0 are left; rewind()");
}

TEST(RawVolume, a_file_without_data_is_an_error) {
  const std::string path = temporary_path("v_4x3x2_u16.raw");
  write_file(path, small_samples(SampleType::u16, false));
  VolumeFile none = describe_raw(path, {}).value();
  none.data_paths.clear();
  EXPECT_NE(VolumeReader::open(none).error().message.find("no data file"), std::string::npos);
  VolumeFile before = describe_raw(path, {}).value();
  before.start.file_offset = -1;
  EXPECT_NE(VolumeReader::open(before).error().message.find("begin before"), std::string::npos);
}

TEST(RawVolume, options_win_over_the_name) {
  const std::string path = temporary_path("v_9x9x9_f64_be.dat");
  write_file(path, "skip" + small_samples(SampleType::i16, false));
  RawOptions options{kSmallDimensions, SampleType::i16, false, 4, Vec3d(1, 2, 3)};
  const auto samples = load(path, options);
  ASSERT_TRUE(samples.ok()) << outcome(samples);
  EXPECT_EQ(samples.value(), native_small_samples(SampleType::i16));
  const auto description = describe(path, options);
  EXPECT_EQ(description.value().voxel_to_world, scaling({1, 2, 3}));
  EXPECT_FALSE(description.value().anatomical);
}

TEST(RawVolume, any_name_with_dimensions) {
  const std::string path = temporary_path("volume.weird");
  write_file(path, small_samples(SampleType::u8, false));
  EXPECT_TRUE(load(path, RawOptions{.dimensions = kSmallDimensions, .type = SampleType::u8}).ok());
  EXPECT_NE(outcome(load(path)).find("not a file that gvx knows"), std::string::npos);
}

TEST(RawVolume, packed_files_and_concatenated_members) {
  const std::string plain = small_samples(SampleType::i16, true);
  const std::string first = plain.substr(0, 13), second = plain.substr(13);
  const std::string gz = temporary_path("v_4x3x2_i16_be.raw.gz"),
                    bz2 = temporary_path("v_4x3x2_i16_be.raw.bz2");
  write_file(gz, deflated(first, kGzip) + deflated(second, kGzip) + std::string(100, '\0'));
  write_file(bz2, bzipped(first) + bzipped(second) + "padding");
  for (const std::string& path : {gz, bz2}) {
    const auto reader = open_volume(path, {});
    ASSERT_TRUE(reader.ok()) << outcome(reader);
    for (int pass = 0; pass < 2; ++pass) {
      const auto samples = read_all(*reader.value());
      ASSERT_TRUE(samples.ok()) << outcome(samples);
      EXPECT_EQ(samples.value(), native_small_samples(SampleType::i16)) << path;
      EXPECT_TRUE(reader.value()->rewind().ok());
    }
  }
}

TEST(RawVolume, a_broken_checksum_is_an_error) {
  const std::string path = temporary_path("checksum_4x3x2_u8.raw.gz");
  std::string packed = deflated(small_samples(SampleType::u8, false), kGzip);
  packed[packed.size() - 8] = static_cast<char>(packed[packed.size() - 8] ^ 1);
  write_file(path, packed);
  EXPECT_NE(outcome(load(path)).find("broken gzip"), std::string::npos) << outcome(load(path));
}

TEST(RawVolume, the_size_is_checked_before_reading) {
  const std::string path = temporary_path("size_4x3x2_u16.raw");
  write_file(path, std::string(47, 'a'));
  EXPECT_EQ(outcome(describe(path)), path + ": size: expected 48 bytes of data, found 47");
  write_file(path, std::string(49, 'a'));
  EXPECT_EQ(outcome(describe(path)), path + ": size: expected 48 bytes of data, found 49");
  EXPECT_TRUE(describe(path, RawOptions{.offset = 1}).ok());
  write_file(path, std::string(60, 'a'));
  EXPECT_TRUE(describe(path, RawOptions{.offset = 1}).ok());
  EXPECT_FALSE(describe(path, RawOptions{.offset = 13}).ok());
  EXPECT_FALSE(describe(path, RawOptions{.offset = -1}).ok());
  EXPECT_FALSE(describe(path, RawOptions{.offset = std::numeric_limits<std::int64_t>::max()}).ok());
}

TEST(RawVolume, impossible_dimensions_and_spacings) {
  const std::string path = temporary_path("impossible.raw");
  write_file(path, "x");
  constexpr std::int64_t kLongest = 2147483647;
  const auto with = [&](Vec3i dimensions) {
    return outcome(describe(path, RawOptions{.dimensions = dimensions, .type = SampleType::f64}));
  };
  EXPECT_NE(with({0, 1, 1}).find("found 0"), std::string::npos);
  EXPECT_NE(with({-4, 3, -2}).find("found -4"), std::string::npos);
  EXPECT_NE(with({1, 1, kLongest + 1}).find("expected 1 to 2147483647"), std::string::npos);
  EXPECT_NE(with({kLongest, kLongest, kLongest}).find("2^62"), std::string::npos);
  EXPECT_NE(with({1 << 20, 1 << 20, 1 << 19}).find("2^62"), std::string::npos);
  EXPECT_NE(with({1 << 20, 1 << 20, 1 << 18}).find("size: expected"), std::string::npos);
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const RawOptions options{
        .dimensions = Vec3i(1, 1, 1), .type = SampleType::u8, .spacing = Vec3d(1, bad, 1)};
    EXPECT_NE(outcome(describe(path, options)).find("spacing: expected"), std::string::npos);
  }
}

TEST(RawVolume, missing_hints_files_and_folders) {
  const std::string path = temporary_path("nothing.raw");
  write_file(path, "x");
  EXPECT_NE(outcome(describe(path)).find("dimensions: expected"), std::string::npos);
  EXPECT_NE(outcome(describe(path, RawOptions{.dimensions = Vec3i(1, 1, 1)})).find("type: expected"),
            std::string::npos);
  EXPECT_NE(outcome(describe(temporary_path("missing_1x1x1_u8.raw"))).find("cannot open"), std::string::npos);
  const RawOptions one{.dimensions = Vec3i(1, 1, 1), .type = SampleType::u8};
  const std::string folder = temporary_path("empty_folder");
  std::filesystem::create_directory(folder);
  EXPECT_NE(outcome(describe(folder, one)).find("the folder is empty"), std::string::npos);
}

TEST(RawVolume, a_pipe_is_read_once_and_cannot_rewind) {
  const std::string path = temporary_path("pipe");
  std::filesystem::remove(path);
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  for (const bool whole : {true, false}) {
    const std::string bytes = small_samples(SampleType::u16, false).substr(0, whole ? 48 : 31);
    std::thread writer([&] { write_file(path, bytes); });
    const auto reader =
        open_volume(path, RawOptions{.dimensions = kSmallDimensions, .type = SampleType::u16});
    const auto samples = reader.ok() ? read_all(*reader.value()) : Error(reader.error());
    writer.join();
    ASSERT_TRUE(reader.ok()) << outcome(reader);
    EXPECT_EQ(outcome(samples), whole ? "ok" : path + ": data end after 31 of 48 bytes");
    EXPECT_FALSE(reader.value()->rewind().ok());
  }
  std::filesystem::remove(path);
}

TEST(RawVolume, standard_input) {
  const std::string path = temporary_path("input");
  write_file(path, "skip" + small_samples(SampleType::u16, true));
  const int kept = dup(STDIN_FILENO);
  const int input = open(path.c_str(), O_RDONLY);
  ASSERT_GE(input, 0);
  ASSERT_EQ(dup2(input, STDIN_FILENO), STDIN_FILENO);
  const auto samples = load(
      "-",
      RawOptions{.dimensions = kSmallDimensions, .type = SampleType::u16, .big_endian = true, .offset = 4});
  const auto without_type = describe("-", RawOptions{.dimensions = kSmallDimensions});
  close(input);
  if (kept >= 0) {
    dup2(kept, STDIN_FILENO);
    close(kept);
  }
  ASSERT_TRUE(samples.ok()) << outcome(samples);
  EXPECT_EQ(samples.value(), native_small_samples(SampleType::u16));
  EXPECT_NE(outcome(without_type).find("type: expected"), std::string::npos);
}

TEST(SampleTypes, common_spellings) {
  EXPECT_EQ(parse_sample_type("Unsigned  Char"), SampleType::u8);
  EXPECT_EQ(parse_sample_type("uint8_t"), SampleType::u8);
  EXPECT_EQ(parse_sample_type("short"), SampleType::i16);
  EXPECT_EQ(parse_sample_type("FLOAT32"), SampleType::f32);
  EXPECT_EQ(parse_sample_type("double"), SampleType::f64);
  EXPECT_EQ(parse_sample_type("int64"), SampleType::i64);
  EXPECT_EQ(parse_sample_type("unsigned long long"), SampleType::u64);
  EXPECT_EQ(parse_sample_type("int128"), std::nullopt);
  EXPECT_EQ(parse_sample_type(""), std::nullopt);
  for (const SampleType type : kAllSampleTypes) EXPECT_EQ(parse_sample_type(sample_name(type)), type);
}

}  // namespace
}  // namespace gvx::io::test
