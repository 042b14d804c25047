#include "gvx/io/metaimage.h"

#include <map>

#include <gtest/gtest.h>

#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {
namespace {

constexpr int kZlib = 15;

std::string small_mha(const std::string& fields, const std::string& samples,
                      const std::string& type = "MET_UCHAR") {
  return "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = " + type + "\n" + fields +
         "ElementDataFile = LOCAL\n" + samples;
}

std::string little_u8() {
  return small_samples(SampleType::u8, false);
}

TEST(MetaImage, every_sample_type_in_both_byte_orders) {
  const std::map<SampleType, const char*> names = {
      {SampleType::u8, "MET_UCHAR"},       {SampleType::i8, "MET_CHAR"},
      {SampleType::u16, "MET_USHORT"},     {SampleType::i16, "MET_SHORT"},
      {SampleType::u32, "MET_UINT"},       {SampleType::i32, "MET_INT"},
      {SampleType::u64, "MET_ULONG_LONG"}, {SampleType::i64, "MET_LONG_LONG"},
      {SampleType::f32, "MET_FLOAT"},      {SampleType::f64, "MET_DOUBLE"}};
  const std::string path = temporary_path("types.mha");
  for (const SampleType type : kAllSampleTypes) {
    for (const bool big_endian : {false, true}) {
      const std::string order =
          big_endian ? "BinaryDataByteOrderMSB = True\n" : "BinaryDataByteOrderMSB = False\n";
      write_file(path,
                 small_mha("BinaryData = True\n" + order, small_samples(type, big_endian), names.at(type)));
      const auto samples = load(path);
      ASSERT_TRUE(samples.ok()) << outcome(samples);
      EXPECT_EQ(samples.value(), native_small_samples(type)) << names.at(type);
    }
  }
}

TEST(MetaImage, packed_text_and_skipped_data) {
  const std::string path = temporary_path("packed.mha"), data = little_u8();
  std::string text;
  for (int i = 0; i < 24; ++i) text += std::to_string(i * 10) + " ";
  for (const std::string& bytes : {
           small_mha("CompressedData = True\nCompressedDataSize = 17\n", deflated(data, kZlib)),
           small_mha("CompressedData = True\n", deflated(data, kZlib + 16)),
           small_mha("BinaryData = False\n", text),
           small_mha("HeaderSize = -1\n", "whatever" + data),
           small_mha("BinaryData = True\n", data + "trailing"),
       }) {
    write_file(path, bytes);
    const auto samples = load(path);
    ASSERT_TRUE(samples.ok()) << outcome(samples) << bytes;
    EXPECT_EQ(samples.value(), data) << bytes;
  }
}

TEST(MetaImage, detached_data_beside_the_header) {
  const std::string header = "NDims = 3\r\nDimSize = 4 3 2\r\nElementType = MET_UCHAR\r\n";
  write_file(temporary_path("detached.raw"), "HEAD" + little_u8());
  write_file(temporary_path("detached.mhd"), header + "HeaderSize = 4\r\nElementDataFile = detached.raw\r\n");
  const auto samples = load(temporary_path("detached.mhd"));
  ASSERT_TRUE(samples.ok()) << outcome(samples);
  EXPECT_EQ(samples.value(), little_u8());
}

TEST(MetaImage, lists_and_patterns_of_data_files) {
  const std::string header = "NDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n", data = little_u8();
  const std::string path = temporary_path("several.mhd");
  for (const char* name : {"slice01.raw", "slice04.raw"})
    write_file(temporary_path(name), data.substr(0, 12));
  for (const char* name : {"slice02.raw", "slice07.raw"}) write_file(temporary_path(name), data.substr(12));
  for (const char* several : {"LIST\nslice01.raw\nslice02.raw", "LIST 2D\r\nslice01.raw\r\nslice02.raw\r\n",
                              "LIST 2\nslice04.raw\nslice07.raw\n", "slice%02d.raw", "slice%02d.raw 1",
                              "slice%02d.raw 1 2", "slice%02d.raw 1 2 1", "slice%02d.raw 4 9 3"}) {
    write_file(path, header + "ElementDataFile = " + several);
    const auto samples = load(path);
    ASSERT_TRUE(samples.ok()) << outcome(samples);
    EXPECT_EQ(samples.value(), data) << several;
  }
  for (const auto& [several, part] : {std::pair("LIST", "expected 2 files for these sizes, found 0"),
                                      {"LIST\nslice01.raw\nslice09.raw", "slice09.raw: cannot open"},
                                      {"LIST 1\nslice01.raw\nslice02.raw", "expected 6 files"},
                                      {"slice%02d.raw 1 9", "expected 2 files for these sizes, found 9"},
                                      {"slice%02d.raw 9223372036854775807", "expected a pattern such as"},
                                      {"slice%02d.raw 1 2 3 4", "expected a pattern such as"},
                                      {"slice%02d.raw one", "expected numbers behind the first word"},
                                      {"", "expected LOCAL, LIST or a name"}}) {
    write_file(path, header + "ElementDataFile = " + several + "\n");
    EXPECT_NE(outcome(load(path)).find(part), std::string::npos) << outcome(load(path));
  }
}

VolumeDescription described(const std::string& fields) {
  const std::string path = temporary_path("place.mha");
  write_file(path, small_mha(fields, little_u8()));
  const auto description = describe(path);
  EXPECT_TRUE(description.ok()) << outcome(description);
  return description.ok() ? description.value() : VolumeDescription{};
}

TEST(MetaImage, spacing_and_orientation) {
  const VolumeDescription spaced = described("ElementSpacing = 0.5 1 2\nAnatomicalOrientation = ???\n");
  EXPECT_FALSE(spaced.anatomical);
  EXPECT_EQ(spaced.voxel_to_world, scaling({0.5, 1, 2}));

  const VolumeDescription placed =
      described("TransformMatrix = 0 1 0 1 0 0 0 0 1\nOffset = 10 20 30\nElementSpacing = 2 3 4\n");
  EXPECT_TRUE(placed.anatomical);
  EXPECT_EQ(placed.voxel_to_world.point({0.5, 0.5, 0.5}), Vec3d(-10, -20, 30));
  EXPECT_EQ(placed.voxel_to_world.point({1.5, 0.5, 0.5}), Vec3d(-10, -22, 30));
  EXPECT_EQ(placed.voxel_to_world.point({0.5, 1.5, 1.5}), Vec3d(-13, -20, 34));

  const VolumeDescription scaled =
      described("ElementToIntensityFunctionSlope = 2.5\nElementToIntensityFunctionOffset = -7\n");
  EXPECT_EQ(scaled.scale, 2.5);
  EXPECT_EQ(scaled.offset, -7);
}

TEST(MetaImage, two_and_four_axes) {
  const std::string path = temporary_path("axes.mha");
  const std::string tail = "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + little_u8();
  write_file(path, "NDims = 2\nDimSize = 6 4\nElementSpacing = 2 3\nTransformMatrix = 0 1 1 0\n" + tail);
  const auto flat = describe(path);
  ASSERT_TRUE(flat.ok()) << outcome(flat);
  EXPECT_EQ(flat.value().dimensions, Vec3i(6, 4, 1));
  EXPECT_EQ(flat.value().voxel_to_world.column[0], Vec3d(0, -2, 0));
  write_file(path, "NDims = 4\nDimSize = 4 3 2 1\n" + tail);
  EXPECT_EQ(describe(path).value().dimensions, kSmallDimensions);
  write_file(path, "NDims = 4\nDimSize = 2 3 2 2\n" + tail);
  EXPECT_NE(outcome(describe(path)).find("expected one volume, found 2"), std::string::npos);
}

TEST(MetaImage, errors_name_the_field) {
  const std::string path = temporary_path("error.mha"), data = little_u8();
  const auto expect_error = [&](const std::string& bytes, const std::string& part) {
    write_file(path, bytes);
    const std::string message = outcome(load(path));
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  };
  expect_error("", "is empty");
  expect_error("NDims = 3\nbinary junk\n", "found 'binary junk'");
  expect_error(small_mha("NDims = 3\n", data), "two of 'ndims'");
  expect_error(small_mha("", data, "MET_UCHAR_ARRAY"), "ElementType: expected MET_CHAR");
  expect_error(small_mha("ElementNumberOfChannels = 5\n", data), "ElementNumberOfChannels: expected 1 to 4");
  expect_error(small_mha("CompressedData = maybe\n", data), "CompressedData: expected True or False");
  expect_error(small_mha("ElementSpacing = 1 0 1\n", data), "ElementSpacing: expected");
  expect_error(small_mha("ElementSpacing = 1 nan 1\n", data), "ElementSpacing: expected");
  expect_error(small_mha("TransformMatrix = 1 0 0 1 0 0 0 0 1\n", data), "orientation: expected");
  expect_error(small_mha("TransformMatrix = 1 0 0\n", data), "TransformMatrix: expected 9 finite numbers");
  expect_error(small_mha("HeaderSize = -2\n", data), "HeaderSize: expected");
  expect_error(small_mha("HeaderSize = 99999\n", data), "ends before byte 99999");
  expect_error(small_mha("HeaderSize = -1\nCompressedData = True\n", data), "HeaderSize: expected");
  expect_error(small_mha("ElementToIntensityFunctionSlope = 0\n", data), "value scale: expected");
  expect_error(small_mha("", data.substr(1)), "expected 24 bytes of data, found 23");
  expect_error(small_mha("CompressedData = True\n", "not zlib data at all"), "broken gzip or zlib data");
}

}  // namespace
}  // namespace gvx::io::test
