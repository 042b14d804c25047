#include "gvx/io/nifti.h"

#include <cmath>
#include <limits>
#include <map>

#include <gtest/gtest.h>

#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {
namespace {

constexpr int kGzip = 15 + 16;

const std::map<SampleType, std::int16_t> kDatatypes = {
    {SampleType::u8, 2},    {SampleType::i8, 256}, {SampleType::u16, 512},  {SampleType::i16, 4},
    {SampleType::u32, 768}, {SampleType::i32, 8},  {SampleType::u64, 1280}, {SampleType::i64, 1024},
    {SampleType::f32, 16},  {SampleType::f64, 64}};

/// A header that tests change by byte offset.
struct Header {
  explicit Header(SampleType type, bool big = false) : big_endian(big) {
    set<std::int32_t>(0, 348);
    set_shorts(40, {3, 4, 3, 2, 1, 1, 1, 1});
    set<std::int16_t>(70, kDatatypes.at(type));
    set<std::int16_t>(72, static_cast<std::int16_t>(8 * sample_bytes(type)));
    for (std::size_t i = 0; i < 4; ++i) set<float>(76 + 4 * i, 1.0f);
    set<float>(108, 352.0f);
    bytes.replace(344, 4, std::string("n+1\0", 4));
  }

  template <typename T>
  Header& set(std::size_t offset, T value) {
    bytes_of(value, big_endian).copy(bytes.data() + offset, sizeof value);
    return *this;
  }
  Header& set_shorts(std::size_t offset, std::initializer_list<int> values) {
    for (const int value : values) {
      set<std::int16_t>(offset, static_cast<std::int16_t>(value));
      offset += 2;
    }
    return *this;
  }
  Header& set_floats(std::size_t offset, std::initializer_list<double> values) {
    for (const double value : values) {
      set<float>(offset, static_cast<float>(value));
      offset += 4;
    }
    return *this;
  }

  bool big_endian;
  std::string bytes = std::string(352, '\0');
};

Result<VolumeDescription> described(const Header& header) {
  const std::string path = temporary_path("described.nii");
  write_file(path, header.bytes + small_samples(SampleType::u8, false));
  return describe(path);
}

TEST(Nifti, every_sample_type_in_both_byte_orders_plain_and_packed) {
  for (const SampleType type : kAllSampleTypes) {
    for (const bool big_endian : {false, true}) {
      const std::string bytes = Header(type, big_endian).bytes + small_samples(type, big_endian);
      write_file(temporary_path("types.nii"), bytes);
      write_file(temporary_path("types.nii.gz"), deflated(bytes, kGzip));
      for (const char* name : {"types.nii", "types.nii.gz"}) {
        const auto samples = load(temporary_path(name));
        ASSERT_TRUE(samples.ok()) << outcome(samples);
        EXPECT_EQ(samples.value(), native_small_samples(type)) << name << sample_name(type);
      }
    }
  }
}

TEST(Nifti, pairs_by_either_name) {
  Header header(SampleType::u8);
  header.bytes.replace(344, 4, std::string("ni1\0", 4));
  header.set<float>(108, 0.0f).set_floats(80, {1, 2, 3});
  const std::string data = small_samples(SampleType::u8, false);
  write_file(temporary_path("pair.hdr"), header.bytes.substr(0, 348));
  write_file(temporary_path("pair.img"), data);
  write_file(temporary_path("packed.hdr"), header.bytes.substr(0, 348));
  write_file(temporary_path("packed.img.gz"), deflated(data, kGzip));
  header.bytes.replace(344, 4, std::string(4, '\0'));
  write_file(temporary_path("analyze.hdr"), header.bytes.substr(0, 348));
  write_file(temporary_path("analyze.img"), data);
  for (const char* name :
       {"pair.hdr", "pair.img", "packed.hdr", "packed.img.gz", "analyze.hdr", "analyze.img"}) {
    const auto samples = load(temporary_path(name));
    ASSERT_TRUE(samples.ok()) << outcome(samples);
    EXPECT_EQ(samples.value(), data) << name;
    EXPECT_EQ(describe(temporary_path(name)).value().voxel_to_world, scaling({1, 2, 3})) << name;
  }
  const std::vector<std::string> packed_files = {temporary_path("packed.hdr"),
                                                 temporary_path("packed.img.gz")};
  EXPECT_EQ(volume_files(temporary_path("packed.hdr"), {}), packed_files);
  write_file(temporary_path("lonely.img"), data);
  EXPECT_NE(outcome(load(temporary_path("lonely.img"))).find("lonely.hdr: cannot open"), std::string::npos);
}

TEST(Nifti, scale_slope) {
  Header header(SampleType::u8);
  header.set<float>(112, 2.5f).set<float>(116, -7.0f);
  EXPECT_EQ(described(header).value().scale, 2.5);
  EXPECT_EQ(described(header).value().offset, -7);
  for (const float none : {0.0f, std::numeric_limits<float>::quiet_NaN()}) {
    header.set<float>(112, none);
    EXPECT_EQ(described(header).value().scale, 1);
    EXPECT_EQ(described(header).value().offset, 0);
  }
}

TEST(Nifti, sform_then_qform_then_pixdim) {
  Header header(SampleType::u8);
  header.set_floats(80, {2, 3, 4});
  EXPECT_EQ(described(header).value().voxel_to_world, scaling({2, 3, 4}));
  EXPECT_FALSE(described(header).value().anatomical);

  // A quarter turn about z: i runs along +y, j along -x.
  const double half = std::sqrt(0.5);
  header.set_shorts(252, {1, 0}).set_floats(256, {0, 0, half, 10, 20, 30});
  const auto turned = described(header);
  ASSERT_TRUE(turned.ok()) << outcome(turned);
  EXPECT_TRUE(turned.value().anatomical);
  EXPECT_NEAR(length(turned.value().voxel_to_world.point({0.5, 0.5, 0.5}) - Vec3d(10, 20, 30)), 0, 1e-6);
  EXPECT_NEAR(length(turned.value().voxel_to_world.column[0] - Vec3d(0, 2, 0)), 0, 1e-6);
  EXPECT_NEAR(length(turned.value().voxel_to_world.column[1] - Vec3d(-3, 0, 0)), 0, 1e-6);
  EXPECT_NEAR(length(turned.value().voxel_to_world.column[2] - Vec3d(0, 0, 4)), 0, 1e-6);
  header.set<float>(76, -1.0f);
  EXPECT_NEAR(length(described(header).value().voxel_to_world.column[2] - Vec3d(0, 0, -4)), 0, 1e-6);

  header.set_shorts(254, {1}).set_floats(280, {-2, 0, 0, 5, 0, 2, 0, 6, 0, 0.5, 2, 7});
  const auto sheared = described(header);
  ASSERT_TRUE(sheared.ok()) << outcome(sheared);
  EXPECT_EQ(sheared.value().voxel_to_world.point({0.5, 0.5, 0.5}), Vec3d(5, 6, 7));
  EXPECT_EQ(sheared.value().voxel_to_world.point({1.5, 1.5, 1.5}), Vec3d(3, 8, 9.5));

  header.bytes[123] = 3;  // micrometres
  EXPECT_NEAR(
      length(described(header).value().voxel_to_world.point({0.5, 0.5, 0.5}) - Vec3d(5e-3, 6e-3, 7e-3)), 0,
      1e-9);
}

TEST(Nifti, unusable_matrices_fall_back) {
  Header header(SampleType::u8);
  const double nan = std::nan("");
  header.set_floats(80, {0, -3, nan}).set_shorts(252, {1, 1});
  header.set_floats(256, {nan, 0, 0, 0, 0, 0}).set_floats(280, {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0});
  const auto description = described(header);
  ASSERT_TRUE(description.ok()) << outcome(description);
  EXPECT_EQ(description.value().voxel_to_world, scaling({1, 3, 1}));
  EXPECT_FALSE(description.value().anatomical);
}

TEST(Nifti, errors_name_the_field) {
  const auto expect_error = [](const Header& header, const std::string& part) {
    const std::string message = outcome(described(header));
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  const Header good(SampleType::u8);
  EXPECT_EQ(outcome(described(good)), "ok");
  expect_error(Header(good).set<std::int32_t>(0, 540), "header: expected 540 bytes, found 376");
  expect_error(Header(good).set<std::int32_t>(0, 7),
               "sizeof_hdr: expected 348 (NIfTI-1) or 540 (NIfTI-2), found 7");
  expect_error(Header(good).set_shorts(40, {8}), "dim[0]: expected");
  expect_error(Header(good).set_shorts(40, {1}), "dim[0]: expected");
  expect_error(Header(good).set_shorts(42, {-4}), "dim[1]: expected 1 or more, found -4");
  expect_error(Header(good).set_shorts(40, {4, 4, 3, 2, 5}), "size: expected 472 bytes of data, found 376");
  expect_error(Header(good).set_shorts(40, {5, 4, 3, 2, 3, 5}), "dim[5]: expected 1 to 4 numbers a voxel");
  expect_error(Header(good).set_shorts(40, {6, 4, 3, 2, 1, 1, 2}), "dim[6]: expected 1, found 2");
  expect_error(Header(good).set_shorts(70, {32}), "(complex numbers)");
  expect_error(Header(good).set_shorts(70, {1536}), "(numbers of 128 bits)");
  expect_error(Header(good).set_shorts(70, {12345}), "found code 12345");
  expect_error(Header(good).set<std::int32_t>(344, 0), "magic: expected");
  expect_error(Header(good).set_floats(108, {351}), "vox_offset: expected");
  expect_error(Header(good).set_floats(108, {352.5}), "vox_offset: expected");
  expect_error(Header(good).set_floats(108, {std::nan("")}), "vox_offset: expected");
  expect_error(Header(good).set_floats(108, {1e12}), "size: expected");
  expect_error(Header(good).set_floats(112, {1, std::nan("")}), "scl_inter: expected");
  expect_error(Header(good).set_shorts(42, {32767, 32767, 32767}), "size: expected");
  EXPECT_EQ(described(Header(good).set_shorts(40, {4, 4, 3, 2, 1})).value().dimensions, kSmallDimensions);
  EXPECT_EQ(described(Header(good).set_shorts(40, {2, 4, 3, 99})).value().dimensions, Vec3i(4, 3, 1));
  EXPECT_TRUE(described(Header(good).set_floats(108, {0})).ok());
}

TEST(Nifti, counts_below_one_are_one) {
  const Header good(SampleType::u8);
  EXPECT_EQ(described(Header(good).set_shorts(40, {4, 4, 3, 2, 0})).value().dimensions, kSmallDimensions);
  EXPECT_EQ(described(Header(good).set_shorts(40, {7, 4, 3, 2, -1, 0, 1, -32768})).value().dimensions,
            kSmallDimensions);
  EXPECT_EQ(described(Header(good).set_shorts(40, {3, 4, 3, 0})).value().dimensions, Vec3i(4, 3, 1));
  EXPECT_EQ(described(Header(good).set_shorts(40, {3, 4, 0, -2})).value().dimensions, Vec3i(4, 1, 1));
  // What is beyond dim[0] counts for nothing.
  EXPECT_EQ(described(Header(good).set_shorts(40, {3, 4, 3, 2, 7, 7})).value().dimensions, kSmallDimensions);
  EXPECT_NE(outcome(described(Header(good).set_shorts(40, {3, 0, 3, 2}))).find("dim[1]: expected 1 or more"),
            std::string::npos);
}

/// A NIfTI-2 header; numbers are named by their byte offsets in nifti2.h.
struct Header2 {
  explicit Header2(SampleType type, bool big = false) : big_endian(big) {
    set<std::int32_t>(0, 540);
    bytes.replace(4, 8, std::string("n+2\0\r\n\032\n", 8));
    set<std::int16_t>(12, kDatatypes.at(type));
    const std::int64_t dim[] = {3, 4, 3, 2, 1, 1, 1, 1};
    for (std::size_t i = 0; i < 8; ++i) set<std::int64_t>(16 + 8 * i, dim[i]);
    for (std::size_t i = 0; i < 4; ++i) set<double>(104 + 8 * i, 1);
    set<std::int64_t>(168, 544);
  }

  template <typename T>
  Header2& set(std::size_t offset, T value) {
    bytes_of(value, big_endian).copy(bytes.data() + offset, sizeof value);
    return *this;
  }

  bool big_endian;
  std::string bytes = std::string(544, '\0');
};

TEST(Nifti, second_version) {
  const std::string path = temporary_path("second.nii");
  for (const SampleType type : kAllSampleTypes) {
    for (const bool big_endian : {false, true}) {
      write_file(path, Header2(type, big_endian).bytes + small_samples(type, big_endian));
      const auto samples = load(path);
      ASSERT_TRUE(samples.ok()) << outcome(samples);
      EXPECT_EQ(samples.value(), native_small_samples(type)) << sample_name(type);
    }
  }
  const std::string data = small_samples(SampleType::u8, false);
  Header2 header(SampleType::u8);
  header.set<double>(176, 0.1).set<double>(184, 1e9).set<std::int32_t>(348, 1).set<std::int32_t>(500, 3);
  for (std::size_t axis = 0; axis < 3; ++axis)
    header.set<double>(400 + 40 * axis, 2e3).set<double>(424 + 32 * axis, 5e3);
  write_file(path, header.bytes + data);
  const VolumeDescription placed = describe(path).value();
  EXPECT_EQ(placed.scale, 0.1);
  EXPECT_EQ(placed.offset, 1e9);
  EXPECT_TRUE(placed.anatomical);
  EXPECT_NEAR(length(placed.voxel_to_world.point({1.5, 0.5, 0.5}) - Vec3d(7, 5, 5)), 0, 1e-9);

  write_file(temporary_path("second.hdr"),
             Header2(SampleType::u8).set<std::int64_t>(168, 0).bytes.replace(4, 3, "ni2"));
  write_file(temporary_path("second.img"), data);
  EXPECT_EQ(load(temporary_path("second.hdr")).value(), data);
  const auto error_of = [&](const Header2& wrong) {
    write_file(path, wrong.bytes + data);
    return outcome(load(path));
  };
  EXPECT_NE(
      error_of(Header2(SampleType::u8).set<std::int64_t>(16, 4).set<std::int64_t>(48, std::int64_t{1} << 40))
          .find("size: expected"),
      std::string::npos);
  EXPECT_NE(
      error_of(Header2(SampleType::u8).set<std::int64_t>(16, 4).set<std::int64_t>(48, std::int64_t{1} << 60))
          .find("dim: expected less than 2^62 bytes in all"),
      std::string::npos);
  EXPECT_NE(error_of(Header2(SampleType::u8).set<std::int64_t>(24, std::int64_t{1} << 40))
                .find("dimensions: expected"),
            std::string::npos);
  EXPECT_NE(error_of(Header2(SampleType::u8).set<std::int64_t>(168, 400)).find("vox_offset: expected"),
            std::string::npos);
  Header2 nameless(SampleType::u8);
  nameless.bytes.replace(4, 3, "abc");
  EXPECT_NE(error_of(nameless).find("magic: expected n+2 or ni2"), std::string::npos);
  write_file(path, header.bytes.substr(0, 400));
  EXPECT_NE(outcome(load(path)).find("header: expected 540 bytes, found 400"), std::string::npos);
}

TEST(Nifti, OneOfSeveralFrames) {
  const std::string all = small_samples(SampleType::u8, false) + std::string(24, 'b') + std::string(24, 'c');
  const std::string header = Header(SampleType::u8).set_shorts(40, {4, 4, 3, 2, 3}).bytes;
  for (const char* name : {"frames.nii", "frames.nii.gz"}) {
    const std::string path = temporary_path(name);
    const bool packed = path.ends_with(".gz");
    write_file(path, packed ? deflated(header + all, kGzip) : header + all);
    for (std::int64_t time = 0; time < 3; ++time) {
      VolumeOptions options;
      options.time = time;
      const auto reader = open_volume(path, options);
      ASSERT_TRUE(reader.ok()) << outcome(reader);
      EXPECT_EQ(reader.value()->description().frames, 3);
      EXPECT_EQ(reader.value()->description().frame, time);
      EXPECT_TRUE(reader.value()->description().remarks.empty());
      EXPECT_EQ(read_all(*reader.value()).value(), all.substr(24 * static_cast<std::size_t>(time), 24));
      // What lies behind are other frames.
      EXPECT_TRUE(reader.value()->surplus().empty());
    }
    EXPECT_EQ(load(path).value(), all.substr(0, 24));
    const VolumeDescription first = describe(path).value();
    ASSERT_EQ(first.remarks.size(), 1u);
    EXPECT_EQ(first.remarks[0], "has 3 frames in time; the first is read (--time 0 to 2 chooses one)");
    VolumeOptions beyond;
    beyond.time = 3;
    EXPECT_NE(outcome(describe(path, beyond)).find("time: expected a frame from 0 to 2, found 3"),
              std::string::npos);
  }
  const std::string path = temporary_path("frames.nii");
  write_file(path, header + all + "more");
  const auto reader = open_volume(path, {});
  ASSERT_TRUE(read_all(*reader.value()).ok());
  const auto surplus = reader.value()->surplus();
  ASSERT_EQ(surplus.size(), 1u);
  EXPECT_EQ(surplus[0].bytes, 4u);
}

TEST(Nifti, VectorsAreChannels) {
  // Two frames of vectors of two numbers: dim[5] is the slowest axis.
  const std::string all =
      std::string(24, 'a') + std::string(24, 'b') + std::string(24, 'A') + std::string(24, 'B');
  const std::string header = Header(SampleType::u8).set_shorts(40, {5, 4, 3, 2, 2, 2}).bytes;
  for (const char* name : {"vectors.nii", "vectors.nii.gz"}) {
    const std::string path = temporary_path(name);
    write_file(path, path.ends_with(".gz") ? deflated(header + all, kGzip) : header + all);
    VolumeOptions options;
    options.time = 1;
    EXPECT_EQ(describe(path, options).value().components, 2);
    EXPECT_EQ(load(path, options).value().substr(0, 4), "bBbB");
    EXPECT_EQ(load(path).value().substr(0, 4), "aAaA");
  }
}

}  // namespace
}  // namespace gvx::io::test
