#include "gvx/io/nrrd.h"

#include <gtest/gtest.h>

#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {
namespace {

constexpr int kGzip = 15 + 16;

/// An attached header of the small volume with `fields` added, and its samples behind.
std::string small_nrrd(const std::string& fields, const std::string& samples,
                       const std::string& type = "u8") {
  return "NRRD0004\n# comment\ndimension: 3\nsizes: 4 3 2\nkey:=value\ntype: " + type + "\n" + fields + "\n" +
         samples;
}

std::string little_u8() {
  return small_samples(SampleType::u8, false);
}

/// Writes a header with one-byte samples and returns the outcome of loading it.
std::string outcome_of(const std::string& bytes) {
  const std::string path = temporary_path("outcome.nrrd");
  write_file(path, bytes);
  return outcome(load(path));
}

TEST(Nrrd, every_sample_type_in_both_byte_orders_and_as_text) {
  const std::string path = temporary_path("types.nrrd");
  for (const SampleType type : kAllSampleTypes) {
    const std::string name =
        type == SampleType::u8    ? "uchar"
        : type == SampleType::i8  ? "signed char"
        : type == SampleType::f32 ? "float"
        : type == SampleType::f64
            ? "double"
            : std::string(sample_name(type)[0] == 'u' ? "uint" : "int") + (sample_name(type) + 1);
    for (const bool big_endian : {false, true}) {
      const std::string endian = big_endian ? "endian: big\n" : "endian: little\n";
      write_file(path, small_nrrd("encoding: raw\n" + endian, small_samples(type, big_endian), name));
      const auto samples = load(path);
      ASSERT_TRUE(samples.ok()) << outcome(samples);
      EXPECT_EQ(samples.value(), native_small_samples(type)) << name;
    }
    std::string text;
    for (int i = 0; i < 24; ++i) {
      text +=
          with_sample_type(type, [&](auto t) { return std::to_string(small_sample<decltype(t)>(i)); }) + "\n";
    }
    write_file(path, small_nrrd("encoding: ascii\n", text, name));
    const auto samples = load(path);
    ASSERT_TRUE(samples.ok()) << outcome(samples);
    EXPECT_EQ(samples.value(), native_small_samples(type)) << name;
  }
}

TEST(Nrrd, packed_and_skipped_data) {
  const std::string data = little_u8();
  for (const std::string& bytes : {
           small_nrrd("encoding: gzip\n", deflated(data, kGzip)),
           small_nrrd("encoding: bzip2\n", bzipped(data)),
           small_nrrd("encoding: raw\nline skip: 2\n", "one\ntwo\n" + data),
           small_nrrd("encoding: raw\nline skip: 1\nbyte skip: 3\n", "one\nabc" + data),
           small_nrrd("encoding: raw\nbyte skip: -1\n", "anything" + data),
           small_nrrd("encoding: gz\nbyte skip: -1\n", deflated("anything" + data, kGzip)),
           small_nrrd("encoding: bz2\nline skip: 1\nbyteskip: 5\n", "a line\n" + bzipped("12345" + data)),
       }) {
    const std::string path = temporary_path("packed.nrrd");
    write_file(path, bytes);
    const auto reader = open_volume(path, {});
    ASSERT_TRUE(reader.ok()) << outcome(reader);
    for (int pass = 0; pass < 2; ++pass) {
      const auto samples = read_all(*reader.value());
      ASSERT_TRUE(samples.ok()) << outcome(samples) << bytes.substr(0, 120);
      EXPECT_EQ(samples.value(), data) << bytes.substr(0, 120);
      ASSERT_TRUE(reader.value()->rewind().ok());
    }
  }
}

TEST(Nrrd, detached_data_beside_the_header) {
  const std::string header = "NRRD0001\r\ndimension: 3\r\nsizes: 4 3 2\r\ntype: uchar\r\nencoding: raw\r\n";
  write_file(temporary_path("detached.raw"), little_u8());
  write_file(temporary_path("detached.nhdr"), header + "data file: detached.raw\r\n");
  const auto samples = load(temporary_path("detached.nhdr"));
  ASSERT_TRUE(samples.ok()) << outcome(samples);
  EXPECT_EQ(samples.value(), little_u8());
  write_file(temporary_path("absent.nhdr"), header + "data file: gvx_no_such_file.raw\r\n");
  EXPECT_NE(outcome(load(temporary_path("absent.nhdr"))).find("cannot open"), std::string::npos);
}

/// The small volume as u16 in slices, rows or pairs of voxels: files of this name with their index behind.
void write_parts(const std::string& name, std::size_t parts, bool packed = false) {
  const std::string data = small_samples(SampleType::u16, false);
  for (std::size_t i = 0; i < parts; ++i) {
    const std::string part = data.substr(i * data.size() / parts, data.size() / parts);
    write_file(temporary_path(name + std::to_string(i)), packed ? deflated(part, kGzip) : part);
  }
}

TEST(Nrrd, lists_of_data_files) {
  const std::string header =
      "NRRD0005\ndimension: 3\nsizes: 4 3 2\ntype: ushort\nendian: little\nencoding: raw\n";
  const std::string path = temporary_path("list.nhdr");
  write_parts("slice", 2);
  write_parts("row", 6);
  write_parts("column", 24);
  write_parts("slab", 1);
  const auto expect_loaded = [&](const std::string& fields) {
    write_file(path, header + fields);
    const auto reader = open_volume(path, {});
    ASSERT_TRUE(reader.ok()) << outcome(reader);
    for (int pass = 0; pass < 2; ++pass) {
      const auto samples = read_all(*reader.value());
      ASSERT_TRUE(samples.ok()) << outcome(samples) << fields;
      EXPECT_EQ(samples.value(), native_small_samples(SampleType::u16)) << fields;
      ASSERT_TRUE(reader.value()->rewind().ok());
    }
  };
  std::string rows;
  for (int i = 0; i < 6; ++i) rows += "row" + std::to_string(i) + "\n";
  expect_loaded("data file: LIST\r\nslice0\r\nslice1\r\n");
  expect_loaded("data file: LIST 2\nslice0\nslice1");
  expect_loaded("datafile: LIST 1\n" + rows + "\nbehind an empty line");
  expect_loaded("data file: LIST 3\nslice0\nslice1\n");
  expect_loaded("data file: slice%d 0 1 1\n");
  expect_loaded("data file: row%d 0 5 1 1\n");
  expect_loaded("data file: slab%d 0 0 1 3\n");
  const std::vector<std::string> files = {path, temporary_path("slice0"), temporary_path("slice1")};
  write_file(path, header + "data file: slice%d 0 1 1\n");
  EXPECT_EQ(volume_files(path, {}), files);

  write_file(temporary_path("down007"), read_file(temporary_path("slice0")));
  write_file(temporary_path("down005"), read_file(temporary_path("slice1")));
  expect_loaded("data file: down%03d 7 5 -2\n");
  write_file(temporary_path("skip0"), "one\ntwo" + read_file(temporary_path("slice0")));
  write_file(temporary_path("skip1"), "a line\nabc" + read_file(temporary_path("slice1")));
  expect_loaded("line skip: 1\nbyte skip: 3\ndata file: skip%d 0 1 1\n");
  expect_loaded("byte skip: -1\ndata file: skip%d 0 1 1\n");
  write_parts("packed", 2, true);
  write_file(path,
             "NRRD0005\ndimension: 3\nsizes: 4 3 2\ntype: ushort\nendian: little\nencoding: gzip\n"
             "data file: packed%01d 0 1 1\n");
  EXPECT_EQ(load(path).value(), native_small_samples(SampleType::u16));
}

TEST(Nrrd, errors_of_lists_name_the_file) {
  const std::string header =
      "NRRD0005\ndimension: 3\nsizes: 4 3 2\ntype: ushort\nendian: little\nencoding: raw\n";
  const std::string path = temporary_path("list.nhdr");
  write_parts("slice", 2);
  write_file(temporary_path("short"), "too short");
  const auto expect_error = [&](const std::string& fields, const std::string& part) {
    write_file(path, header + fields);
    const std::string message = outcome(load(path));
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  };
  expect_error("data file: LIST\nslice0\n", "data file: expected 2 files for these sizes, found 1");
  expect_error("data file: LIST\n", "data file: expected 2 files for these sizes, found 0");
  expect_error("data file: LIST 1\nslice0\nslice1\n", "expected 6 files for these sizes, found 2");
  expect_error("data file: LIST 3\nslice0\nslice1\nshort\n", "share the last axis of 2 evenly, found 3");
  expect_error("data file: LIST 0\nslice0\n", "expected files of 1 to 3 axes, found 0");
  expect_error("data file: LIST 4\nslice0\n", "expected files of 1 to 3 axes, found 4");
  expect_error("data file: LIST two\nslice0\n", "expected numbers behind the first word");
  expect_error("data file: LIST\nslice0\nabsent\n", "absent: cannot open");
  expect_error("data file: LIST\nslice0\nshort\n", "short: size: expected 24 bytes, found 9");
  expect_error("data file: LIST\nshort\nslice1\n", "short: size: expected 24 bytes of data, found 9");
  expect_error("data file: slice%d 0 5 1\n", "expected 2 files for these sizes, found 6");
  expect_error("data file: slice%d 0 1 0\n", "expected a pattern such as");
  expect_error("data file: slice%d 0 1 -1\n", "expected a pattern such as");
  expect_error("data file: slice%d 0 1\n", "expected a pattern such as");
  expect_error("data file: slice%d%d 0 1 1\n", "expected a pattern such as");
  expect_error("data file: slice%d 0 9223372036854775807 1\n", "expected a pattern such as");
  expect_error("data file: slice%d -9223372036854775808 9223372036854775807 1\n",
               "expected a pattern such as");
  expect_error("data file: slice%99999999999999999999d 0 1 1\n", "cannot open");
  expect_error("data file: 50%.raw\n", "50%.raw: cannot open");
}

VolumeDescription described(const std::string& fields) {
  const std::string path = temporary_path("place.nrrd");
  write_file(path, small_nrrd("encoding: raw\n" + fields, little_u8()));
  const auto description = describe(path);
  EXPECT_TRUE(description.ok()) << outcome(description);
  return description.ok() ? description.value() : VolumeDescription{};
}

TEST(Nrrd, spacing_and_orientation) {
  const VolumeDescription spaced = described("spacings: 0.5 nan 2\n");
  EXPECT_EQ(spaced.voxel_to_world, scaling({0.5, 1, 2}));
  EXPECT_FALSE(spaced.anatomical);

  const std::string oriented = "space directions: (0,2,0) (3,0,0) ( 0, 0, 4 )\nspace origin: (10,20,30)\n";
  const VolumeDescription ras = described("space: right-anterior-superior\n" + oriented);
  EXPECT_TRUE(ras.anatomical);
  EXPECT_EQ(ras.voxel_to_world.point({0.5, 0.5, 0.5}), Vec3d(10, 20, 30));
  EXPECT_EQ(ras.voxel_to_world.point({1.5, 0.5, 0.5}), Vec3d(10, 22, 30));
  EXPECT_EQ(ras.voxel_to_world.point({0.5, 1.5, 0.5}), Vec3d(13, 20, 30));

  const VolumeDescription lps = described("space: LPS\n" + oriented);
  EXPECT_EQ(lps.voxel_to_world.point({1.5, 0.5, 1.5}), Vec3d(-10, -22, 34));
  const VolumeDescription las = described("space: left-anterior-superior\n" + oriented);
  EXPECT_EQ(las.voxel_to_world.point({1.5, 0.5, 1.5}), Vec3d(-10, 22, 34));
  const VolumeDescription metres = described("space: RAS\nspace units: \"m\" \"m\" \"m\"\n" + oriented);
  EXPECT_EQ(metres.voxel_to_world.point({0.5, 0.5, 0.5}), Vec3d(10000, 20000, 30000));
  EXPECT_FALSE(described("space: 3D-right-handed\n" + oriented).anatomical);
}

TEST(Nrrd, given_spacing_keeps_directions_and_the_first_voxel) {
  const std::string path = temporary_path("respaced.nrrd");
  write_file(path, small_nrrd("encoding: raw\nspace: RAS\nspace directions: (0,2,0) (3,0,0) (0,0,4)\n"
                              "space origin: (10,20,30)\n",
                              little_u8()));
  const auto description = describe(path, RawOptions{.spacing = Vec3d(1, 5, 6)});
  ASSERT_TRUE(description.ok()) << outcome(description);
  EXPECT_EQ(description.value().voxel_to_world.point({0.5, 0.5, 0.5}), Vec3d(10, 20, 30));
  EXPECT_EQ(description.value().voxel_to_world.point({1.5, 1.5, 1.5}), Vec3d(15, 21, 36));
  EXPECT_NE(outcome(describe(path, RawOptions{.dimensions = kSmallDimensions})).find("describes itself"),
            std::string::npos);
}

TEST(Nrrd, two_and_four_axes) {
  const std::string path = temporary_path("axes.nrrd");
  const std::string tail = "type: u8\nencoding: raw\n";
  write_file(path, "NRRD0004\ndimension: 2\nsizes: 6 4\n" + tail + "\n" + little_u8());
  EXPECT_EQ(describe(path).value().dimensions, Vec3i(6, 4, 1));
  write_file(path, "NRRD0004\ndimension: 4\nsizes: 4 3 2 1\n" + tail + "\n" + little_u8());
  EXPECT_EQ(describe(path).value().dimensions, kSmallDimensions);
  write_file(path,
             "NRRD0004\ndimension: 4\nsizes: 1 4 3 2\nkinds: vector domain domain domain\n"
             "space: RAS\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n" +
                 tail + "\n" + little_u8());
  EXPECT_EQ(describe(path).value().dimensions, kSmallDimensions);
  write_file(path, "NRRD0004\ndimension: 3\nsizes: 3 4 2\nkinds: RGB-color domain domain\n" + tail + "\n" +
                       little_u8());
  EXPECT_EQ(describe(path).value().dimensions, Vec3i(4, 2, 1));
  EXPECT_EQ(describe(path).value().components, 3);
  EXPECT_TRUE(describe(path).value().colors);
  write_file(path, "NRRD0004\ndimension: 4\nsizes: 2 4 3 1\nkinds: vector domain domain domain\n" + tail +
                       "\n" + little_u8());
  EXPECT_EQ(describe(path).value().components, 2);
  EXPECT_FALSE(describe(path).value().colors);
  for (const char* sizes : {"6 4 1\nkinds: vector domain domain", "4 3 2\nkinds: domain domain RGB-color"}) {
    write_file(path,
               std::string("NRRD0004\ndimension: 3\nsizes: ") + sizes + "\n" + tail + "\n" + little_u8());
    EXPECT_NE(outcome(describe(path)).find("expected one to four numbers a voxel"), std::string::npos);
  }
  write_file(path, "NRRD0004\ndimension: 4\nsizes: 2 2 3 2\n" + tail + "\n" + little_u8());
  EXPECT_NE(outcome(describe(path)).find("found 4 axes"), std::string::npos);
  write_file(path, "NRRD0004\ndimension: 1\nsizes: 24\n" + tail + "\n" + little_u8());
  EXPECT_NE(outcome(describe(path)).find("found 1 axes"), std::string::npos);
}

TEST(Nrrd, errors_name_the_field) {
  const std::string data = little_u8();
  const auto expect_error = [](const std::string& bytes, const std::string& part) {
    const std::string message = outcome_of(bytes);
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  };
  expect_error("NRRD0009\n", "magic: expected");
  expect_error("", "is empty");
  expect_error(small_nrrd("", data), "encoding: expected this field");
  expect_error(small_nrrd("encoding: hex\n", data), "encoding: expected");
  expect_error(small_nrrd("encoding: raw\n", data, "block"), "type: expected");
  expect_error(small_nrrd("encoding: raw\n", data + data, "short"), "endian: expected");
  expect_error(small_nrrd("encoding: raw\nsizes: 4 3 2\n", data), "two of 'sizes'");
  expect_error(small_nrrd("encoding: raw\nno colon\x01 here\n", data), "'no colon? here'");
  expect_error(small_nrrd("encoding: raw\nspacings: 1 0 1\n", data), "spacings: expected");
  expect_error(small_nrrd("encoding: raw\nspacings: 1 1\n", data), "spacings: expected");
  expect_error(small_nrrd("encoding: raw\nspace directions: (1,0,0) (2,0,0) (0,0,1)\n", data),
               "orientation: expected");
  expect_error(small_nrrd("encoding: raw\nspace directions: (1,0,0) (0,inf,0) (0,0,1)\n", data),
               "orientation: expected");
  expect_error(small_nrrd("encoding: raw\nspace directions: (1,0,0)\n", data), "space directions: expected");
  expect_error(small_nrrd("encoding: raw\nspace origin: 1 2 3\n", data), "space origin: expected");
  expect_error(small_nrrd("encoding: raw\nbyte skip: -5\n", data), "byte skip: expected");
  expect_error(small_nrrd("encoding: raw\nline skip: 99\n", data), "line skip: expected");
  expect_error(small_nrrd("encoding: raw\n", data.substr(1)), "expected 24 bytes of data, found 23");
  expect_error(small_nrrd("encoding: raw\nbyte skip: -1\n", "x"), "data end after 1 of 24 bytes");
  expect_error(small_nrrd("encoding: gzip\n", deflated(data.substr(4), kGzip)),
               "data end after 20 of 24 bytes");
  expect_error(small_nrrd("encoding: ascii\n", "1 2 3"), "data end after 3 of 24 bytes");
  expect_error(small_nrrd("encoding: ascii\n", "1 2 256"), "expected a number of type u8, found '256'");
  expect_error(small_nrrd("encoding: ascii\n", "1 2 x"), "found 'x'");
  expect_error("NRRD0004\n# " + std::string(2 << 20, 'a'), "empty line within the first MiB");
}

}  // namespace
}  // namespace gvx::io::test
