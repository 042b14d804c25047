#include "gvx/io/dicom.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <unistd.h>

#include "gvx/io/dicom_test_support.h"
#include "gvx/io/isolated.h"

namespace gvx::io::test {
namespace {

constexpr int kBareDeflate = -15;

/// The first pixel's value and the last one's of a file.
std::pair<double, double> ends(const std::string& path, const VolumeOptions& options = {}) {
  const auto values = values_of(path, options);
  EXPECT_TRUE(values.ok()) << outcome(values);
  return values.ok() ? std::pair(values.value().front(), values.value().back()) : std::pair(-1.0, -1.0);
}

TEST(Dicom, TransferSyntaxesThatAreNotPacked) {
  const std::string path = temporary_path("syntax.dcm");
  const std::pair<double, double> expected(300, 311);
  const std::string plain = dicom_slice(3, {0, 0, 0}).bytes();
  write_file(path, DicomWriter::file(kExplicit, plain));
  EXPECT_EQ(ends(path), expected);
  write_file(path, DicomWriter::file(kImplicit, dicom_slice(3, {0, 0, 0}, DicomWriter(false)).bytes()));
  EXPECT_EQ(ends(path), expected);
  write_file(path, DicomWriter::file(kBigEndian, dicom_slice(3, {0, 0, 0}, DicomWriter(true, true)).bytes()));
  EXPECT_EQ(ends(path), expected);
  write_file(path, DicomWriter::file(kDeflated, deflated(plain, kBareDeflate)));
  EXPECT_EQ(ends(path), expected);
  const std::string packed = temporary_path("syntax.dcm.gz");
  write_file(packed, deflated(DicomWriter::file(kExplicit, plain), 15 + 16));
  EXPECT_EQ(ends(packed), expected);
  // Neither a preamble nor file meta information, and no name that says what it is.
  const std::string bare = temporary_path("bare");
  write_file(bare, plain);
  EXPECT_EQ(ends(bare), expected);
  EXPECT_TRUE(is_dicom(bare));
  write_file(path, DicomWriter::file("1.2.840.10008.1.2.4.100", plain));
  EXPECT_NE(outcome(describe(path)).find("(0002,0010) TransferSyntaxUID: expected"), std::string::npos);
}

TEST(Dicom, RunLengths) {
  // Two byte planes, the high one first: a run and literal bytes (PS3.5, section G).
  DicomWriter slice = dicom_slice(0, {0, 0, 0});
  std::string code;
  for (const std::uint32_t number : {2u, 64u, 66u}) code += bytes_of(number, false);
  code.resize(64, '\0');
  code += std::string("\xF5\x01", 2);                                               // 12 times 1
  code += std::string("\x0B\0\x01\x02\x03\x04\x05\x06\x07\x08\x09\x0A\x0B\0", 14);  // 0 to 11, padded
  // In two fragments, as one bitstream may be.
  slice.fragments({code.substr(0, 64), code.substr(64)});
  const std::string path = temporary_path("rle.dcm");
  write_file(path, DicomWriter::file(kRunLengths, slice.bytes()));
  EXPECT_EQ(ends(path), std::pair(256.0, 267.0));
  slice.fragments({code.substr(0, code.size() - 8)});
  write_file(path, DicomWriter::file(kRunLengths, slice.bytes()));
  const auto cut = values_of(path);
  EXPECT_EQ(outcome(cut), path + ": RLE: segment 2 ends after 5 of 12 pixels");
}

TEST(Dicom, BitsThatAreNotStoredDoNotCount) {
  const std::string path = temporary_path("bits.dcm");
  DicomWriter slice = dicom_slice(0, {0, 0, 0}).u16(0x00280101, {12}).u16(0x00280102, {11});
  std::string pixels;
  for (int i = 0; i < 12; ++i) pixels += bytes_of(static_cast<std::uint16_t>(0xA800 + i), false);
  slice.element(kPixelData, "OW", pixels);
  write_dicom(path, slice);
  EXPECT_EQ(ends(path), std::pair(-2048.0, -2037.0)) << "bit 11 is the sign";
  write_dicom(path, slice.u16(0x00280103, {0}));
  EXPECT_EQ(ends(path), std::pair(2048.0, 2059.0));
  write_dicom(path, slice.u16(0x00280102, {15}));
  EXPECT_EQ(ends(path), std::pair(double{0xA80}, double{0xA80})) << "the upper 12 bits";
}

TEST(Dicom, SlopesAreThoseOfEachSlice) {
  const std::string folder = new_folder("slopes");
  for (int i = 0; i < 2; ++i) {
    write_dicom(folder + "/" + std::to_string(i), dicom_slice(i, {0, 0, 2.0 * i})
                                                      .text(0x00281053, "DS", i == 0 ? "0.5" : "2")
                                                      .text(0x00281052, "DS", "-1"));
  }
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_EQ(d.value().type, SampleType::f32);
  EXPECT_EQ(d.value().scale, 1);
  EXPECT_EQ(ends(folder), std::pair(-1.0, 2 * 111 - 1.0));
  const auto one = describe(folder + "/1");
  ASSERT_TRUE(one.ok()) << outcome(one);
  EXPECT_EQ(one.value().type, SampleType::i16);
  EXPECT_EQ(one.value().scale, 2);
  EXPECT_EQ(one.value().offset, -1);
}

TEST(Dicom, ColoursArePalettesPlanesAndPixels) {
  const std::string path = temporary_path("colours.dcm");
  DicomWriter slice = dicom_slice(0, {0, 0, 0})
                          .u16(0x00280100, {8})
                          .u16(0x00280101, {8})
                          .u16(0x00280102, {7})
                          .u16(0x00280103, {0});
  std::string pixels;
  for (int i = 0; i < 12; ++i) pixels += static_cast<char>(5 + i % 3);
  slice.element(kPixelData, "OB", pixels).text(0x00280004, "CS", "PALETTE COLOR");
  for (DicomTag c = 0; c < 3; ++c) {
    slice.u16(0x00281101 + c, {3, 5, 16});
    std::string words;
    for (int e = 0; e < 3; ++e)
      words += bytes_of(static_cast<std::uint16_t>((10 * static_cast<int>(c) + e + 1) << 8), false);
    slice.element(0x00281201 + c, "OW", words);
  }
  write_dicom(path, slice);
  auto values = values_of(path);
  ASSERT_TRUE(values.ok()) << outcome(values);
  EXPECT_EQ(std::vector(values.value().begin(), values.value().begin() + 6),
            (std::vector<double>{1, 11, 21, 2, 12, 22}));

  std::string planes;
  for (int i = 0; i < 36; ++i) planes += static_cast<char>(i);
  slice.u16(0x00280002, {3})
      .text(0x00280004, "CS", "RGB")
      .u16(0x00280006, {1})
      .element(kPixelData, "OB", planes);
  write_dicom(path, slice);
  values = values_of(path);
  ASSERT_TRUE(values.ok()) << outcome(values);
  EXPECT_EQ(std::vector(values.value().begin(), values.value().begin() + 3),
            (std::vector<double>{0, 12, 24}));
  EXPECT_TRUE(describe(path).value().colors);

  // Two gray pixels share their colour differences.
  std::string shared;
  for (int i = 0; i < 6; ++i) shared += std::string("\x10\x20\x80\x80", 4);
  slice.text(0x00280004, "CS", "YBR_FULL_422").u16(0x00280006, {0}).element(kPixelData, "OB", shared);
  write_dicom(path, slice);
  values = values_of(path);
  ASSERT_TRUE(values.ok()) << outcome(values);
  EXPECT_EQ(std::vector(values.value().begin(), values.value().begin() + 6),
            (std::vector<double>{16, 16, 16, 32, 32, 32}));
}

/// An enhanced file of 6 frames: 3 places, in the order 2, 0, 1, at 2 points in time, which run fastest.
DicomWriter enhanced() {
  DicomWriter file = dicom_slice(1, {0, 0, 0});
  file.without(0x00200032).without(0x00200037).without(0x00280030).text(0x00280008, "IS", "6");
  file.sequence(0x52009229,
                {DicomWriter()
                     .sequence(0x00209116, {DicomWriter().text(0x00200037, "DS", "1\\0\\0\\0\\1\\0")})
                     .sequence(0x00289110, {DicomWriter().text(0x00280030, "DS", "0.75\\0.5")})});
  std::vector<DicomWriter> frames;
  std::string pixels;
  for (const int z : {2, 0, 1}) {
    for (const int t : {0, 1}) {
      frames.push_back(
          DicomWriter()
              .sequence(0x00209111, {DicomWriter().u32(0x00209128, {static_cast<std::uint32_t>(t + 1)})})
              .sequence(0x00209113, {DicomWriter().text(0x00200032, "DS", decimals({1, 2, 3.0 + 2 * z}))}));
      for (int i = 0; i < 12; ++i) pixels += bytes_of(static_cast<std::int16_t>(100 * z + 50 * t + i), false);
    }
  }
  return file.sequence(0x52009230, frames).element(kPixelData, "OW", pixels);
}

TEST(Dicom, FramesOfAnEnhancedFileAreSortedByPlaceAndTime) {
  const std::string path = temporary_path("enhanced.dcm");
  write_dicom(path, enhanced());
  const auto d = describe(path);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_EQ(d.value().dimensions, Vec3i(4, 3, 3));
  EXPECT_EQ(d.value().frames, 2);
  EXPECT_NEAR(length(d.value().voxel_to_world.column[2]), 2, 1e-9);
  EXPECT_EQ(ends(path), std::pair(0.0, 211.0));
  VolumeOptions second;
  second.time = 1;
  EXPECT_EQ(ends(path, second), std::pair(50.0, 261.0));
  write_dicom(path, enhanced().text(0x00280008, "IS", "7"));
  EXPECT_NE(outcome(describe(path)).find("(7FE0,0010) PixelData: expected 168 bytes for 7 frames"),
            std::string::npos);
}

TEST(Dicom, ErrorsNameTheFileAndTheElement) {
  const std::string path = temporary_path("wrong.dcm");
  const auto error = [&](const DicomWriter& slice) {
    write_dicom(path, slice);
    return outcome(values_of(path));
  };
  const DicomWriter good = dicom_slice(1, {0, 0, 0});
  EXPECT_EQ(error(good), "ok");
  EXPECT_EQ(error(DicomWriter(good).without(0x00280010)), path + ": (0028,0010) Rows: is absent");
  EXPECT_EQ(
      error(DicomWriter(good).u16(0x00280010, {60000}).u16(0x00280011, {60000})),
      path +
          ": (7FE0,0010) PixelData: expected 7200000000 bytes for 1 frame of 60000 x 60000 pixels, found 24");
  EXPECT_EQ(error(DicomWriter(good).u16(0x00280100, {12})),
            path + ": (0028,0100) BitsAllocated: expected 1, 8, 16 or 32, found 12");
  EXPECT_EQ(error(DicomWriter(good).u16(0x00280101, {17})),
            path + ": (0028,0101) BitsStored: expected 1 to 16, found 17");
  EXPECT_EQ(error(DicomWriter(good).without(kPixelData)),
            path + ": (7FE0,0010) PixelData: is absent: the file holds no image");
  EXPECT_EQ(error(DicomWriter(good).text(0x00281053, "DS", "0")),
            path + ": (0028,1053) RescaleSlope: expected a number other than 0");
  write_file(path, "no DICOM at all, but named so");
  EXPECT_EQ(outcome(describe(path)),
            path + ": no DICOM file: expected DICM at byte 128, or an element of group 2 or 8 at byte 0");
  const std::string folder = new_folder("empty");
  write_file(folder + "/a.txt", "text");
  EXPECT_FALSE(is_dicom(folder));
}

TEST(Dicom, DeepSequencesAreRefused) {
  const std::string path = temporary_path("deep.dcm");
  DicomWriter inner;
  for (int depth = 0; depth < 20; ++depth) inner = DicomWriter().sequence(0x00081140, {inner});
  DicomWriter slice = dicom_slice(1, {0, 0, 0});
  const std::string deep = inner.bytes();
  write_file(path, DicomWriter::file(kExplicit, deep + slice.bytes()));
  EXPECT_NE(outcome(describe(path)).find("more than 16 deep"), std::string::npos) << outcome(describe(path));
}

TEST(Dicom, WorkOfAnotherLibraryCannotStopTheProgram) {
  std::vector<std::byte> out(4);
  const auto run = [&](auto work) { return run_isolated(out, std::chrono::seconds(1), work); };
  EXPECT_EQ(run([](std::byte* to) {
              to[3] = std::byte{7};
              return true;
            }),
            IsolatedOutcome::done);
  EXPECT_EQ(out[3], std::byte{7});
  EXPECT_EQ(run([](std::byte*) { return false; }), IsolatedOutcome::failed);
  EXPECT_EQ(run([](std::byte*) -> bool { std::abort(); }), IsolatedOutcome::crashed);
  EXPECT_EQ(run([](std::byte*) -> bool {
              for (;;) usleep(1000);
            }),
            IsolatedOutcome::too_long);
}

TEST(Dicom, BrokenCodesAreErrors) {
  const std::string path = temporary_path("broken_code.dcm");
  // A JPEG whose frame is larger than the file says, and one that ends behind its header.
  const std::string header("\xFF\xD8\xFF\xC3\0\x0B\x10\0\x03\0\x04\x01\x01\x11\0", 15);
  DicomWriter slice = dicom_slice(1, {0, 0, 0});
  slice.fragments({header + std::string("\xFF\xD9", 2) + std::string(1, '\0')});
  write_file(path, DicomWriter::file("1.2.840.10008.1.2.4.70", slice.bytes()));
  const std::string error = outcome(values_of(path));
  if (error.find("built without GDCM") != std::string::npos) GTEST_SKIP() << error;
  EXPECT_EQ(error, path + ": JPEG: the pixels are broken");
  write_file(path, DicomWriter::file("1.2.840.10008.1.2.4.70", slice.u16(0x00280011, {5}).bytes()));
  EXPECT_EQ(outcome(values_of(path)),
            path + ": JPEG: the file says 5 x 3 pixels of 1 samples, the packed frame 4 x 3 of 1");
}

}  // namespace
}  // namespace gvx::io::test
