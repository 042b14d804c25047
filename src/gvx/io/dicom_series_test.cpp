#include "gvx/io/dicom_series.h"

#include <cmath>
#include <filesystem>
#include <system_error>

#include <gtest/gtest.h>

#include "gvx/io/dicom.h"
#include "gvx/io/dicom_test_support.h"

namespace gvx::io::test {
namespace {

/// Where the centre of voxel (i, j, k) lies.
Vec3d centre(const VolumeDescription& d, double i, double j, double k) {
  return d.voxel_to_world.point({i + 0.5, j + 0.5, k + 0.5});
}

void expect_near(Vec3d a, Vec3d b) {
  EXPECT_NEAR(a.x, b.x, 1e-6);
  EXPECT_NEAR(a.y, b.y, 1e-6);
  EXPECT_NEAR(a.z, b.z, 1e-6);
}

std::string joined(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  return all;
}

bool says(const VolumeDescription& d, const std::string& text) {
  return joined(d.remarks).find(text) != std::string::npos;
}

TEST(DicomSeries, SlicesAreSortedByPositionAndPlacedInTheWorld) {
  // Instance numbers and names fall as the position rises.
  const std::string folder = folder_of_slices("sorted", {{10, -20, 34}, {10, -20, 32}, {10, -20, 30}});
  const auto reader = open_volume(folder, {});
  ASSERT_TRUE(reader.ok()) << outcome(reader);
  const VolumeDescription& d = reader.value()->description();
  EXPECT_EQ(d.dimensions, Vec3i(4, 3, 3));
  EXPECT_EQ(d.type, SampleType::i16);
  EXPECT_TRUE(d.anatomical);
  EXPECT_TRUE(d.remarks.empty()) << joined(d.remarks);
  // DICOM's x and y point to the left and the back.
  expect_near(centre(d, 0, 0, 0), {-10, 20, 30});
  expect_near(centre(d, 3, 2, 2), {-10 - 3 * 0.5, 20 - 2 * 0.75, 34});
  const auto values = values_of(folder);
  ASSERT_TRUE(values.ok()) << outcome(values);
  EXPECT_EQ(values.value().front(), 300);
  EXPECT_EQ(values.value().back(), 111);
}

TEST(DicomSeries, SpacingIsThatOfPositionsNotOfThickness) {
  const std::string folder = new_folder("spacing");
  for (int i = 0; i < 3; ++i) {
    write_dicom(folder + "/" + std::to_string(i),
                dicom_slice(i, {0, 0, 7.0 * i}).text(0x00180050, "DS", "5").text(0x00180088, "DS", "2"));
  }
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_NEAR(length(d.value().voxel_to_world.column[2]), 7, 1e-9);
  // A slice alone has nothing else to go by.
  const auto alone = describe(folder + "/1");
  ASSERT_TRUE(alone.ok()) << outcome(alone);
  EXPECT_NEAR(length(alone.value().voxel_to_world.column[2]), 2, 1e-9);
}

TEST(DicomSeries, TiltIsShearAndEvenSlicesStandUpright) {
  const double shift = 2 * std::tan(20 * M_PI / 180);
  std::vector<Vec3d> places;
  for (int i = 0; i < 4; ++i) places.push_back({0, shift * i, 2.0 * i});
  const std::string folder = folder_of_slices("tilted", places);
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_TRUE(says(d.value(), "tilted by 20.0 degrees")) << joined(d.value().remarks);
  for (int i = 0; i < 4; ++i) expect_near(centre(d.value(), 0, 0, i), {0, -shift * i, 2.0 * i});

  VolumeOptions even;
  even.even_slices = true;
  const auto upright = describe(folder, even);
  ASSERT_TRUE(upright.ok()) << outcome(upright);
  EXPECT_EQ(upright.value().type, SampleType::f32);
  EXPECT_EQ(upright.value().dimensions, Vec3i(4, 3 + static_cast<int>(std::ceil(3 * shift / 0.75)), 4));
  expect_near(upright.value().voxel_to_world.column[2], {0, 0, 2});
  const auto values = values_of(folder, even);
  ASSERT_TRUE(values.ok()) << outcome(values);
  EXPECT_EQ(values.value()[0], 100) << "the first slice is not shifted";
  EXPECT_TRUE(std::isnan(values.value()[12])) << "beside the first slice there is nothing";
  // Slice 2 (rows at shift, shift + 0.75, ..) on rows of the grid at multiples of 0.75.
  const auto row = static_cast<std::size_t>(std::ceil(shift / 0.75));
  const double expected = 200 + 4 * (static_cast<double>(row) - shift / 0.75);
  const auto rows = static_cast<std::size_t>(upright.value().dimensions.y);
  EXPECT_NEAR(values.value()[4 * (rows + row)], expected, 1e-4);
}

TEST(DicomSeries, UnevenSlicesAreReportedAndResampledWhenAsked) {
  const std::string folder = folder_of_slices("uneven", {{0, 0, 0}, {0, 0, 2}, {0, 0, 5}, {0, 0, 7}});
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_TRUE(says(d.value(), "not evenly spaced (2.00 to 3.00 mm)")) << joined(d.value().remarks);
  EXPECT_TRUE(says(d.value(), "up to 0.33 mm")) << joined(d.value().remarks);
  VolumeOptions even;
  even.even_slices = true;
  const auto reader = open_volume(folder, even);
  ASSERT_TRUE(reader.ok()) << outcome(reader);
  const std::int64_t depth = reader.value()->description().dimensions.z;
  EXPECT_EQ(depth, 5);  // 7 mm in steps nearest to 2
  const auto values = values_of(folder, even);
  ASSERT_TRUE(values.ok()) << outcome(values);
  const double places[] = {0, 2, 5, 7};
  for (std::int64_t z = 0; z < depth; ++z) {
    const double at = 1.75 * static_cast<double>(z);
    int k = 0;
    while (k < 2 && places[k + 1] < at) ++k;
    const double expected = 100 * (k + 1) + 100 * (at - places[k]) / (places[k + 1] - places[k]);
    EXPECT_NEAR(values.value()[static_cast<std::size_t>(12 * z)], expected, 1e-3) << z;
  }
}

TEST(DicomSeries, MissingSlicesAreCountedAndFilledWhenAsked) {
  const std::string folder = folder_of_slices("missing", {{0, 0, 0}, {0, 0, 2}, {0, 0, 6}, {0, 0, 8}});
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_TRUE(says(d.value(), "1 slice is missing, the first behind slice 2 of 4"))
      << joined(d.value().remarks);
  EXPECT_NEAR(length(d.value().voxel_to_world.column[2]), 2, 1e-9);
  VolumeOptions even;
  even.even_slices = true;
  const auto values = values_of(folder, even);
  ASSERT_TRUE(values.ok()) << outcome(values);
  ASSERT_EQ(values.value().size(), 60u);
  EXPECT_EQ(values.value()[24], 250) << "halfway from slice 2 to slice 3";
  EXPECT_EQ(values.value()[48], 400);
}

TEST(DicomSeries, RoundedPositionsAreEven) {
  const std::string folder = folder_of_slices("jitter", {{0, 0, 0}, {0, 0, 2.004}, {0, 0, 3.996}, {0, 0, 6}});
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_TRUE(d.value().remarks.empty()) << joined(d.value().remarks);
}

TEST(DicomSeries, TheSeriesWithMostSlicesIsReadAndOthersAreNamed) {
  const std::string folder = new_folder("several");
  std::filesystem::create_directories(folder + "/deeper");
  for (int i = 0; i < 3; ++i)
    write_dicom(folder + "/deeper/a" + std::to_string(i), dicom_slice(i, {0, 0, 2.0 * i}));
  for (int i = 0; i < 2; ++i) {
    write_dicom(folder + "/b" + std::to_string(i), dicom_slice(10 + i, {0, 0, 2.0 * i})
                                                       .text(0x0020000E, "UI", "1.2.4")
                                                       .text(0x00200011, "IS", "3")
                                                       .text(0x0008103E, "LO", "scout"));
  }
  write_file(folder + "/readme.txt", "no DICOM");
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_EQ(d.value().dimensions.z, 3);
  EXPECT_TRUE(says(d.value(), "holds 2 series: '7' is read")) << joined(d.value().remarks);
  EXPECT_TRUE(says(d.value(), "1 file is no DICOM file")) << joined(d.value().remarks);
  ASSERT_EQ(d.value().series.size(), 2u);
  EXPECT_EQ(d.value().series[0].number, "3");
  EXPECT_EQ(d.value().series[0].description, "scout");
  EXPECT_EQ(d.value().series[0].dimensions, Vec3i(4, 3, 2));
  VolumeOptions options;
  for (const char* choice : {"3", "1.2.4"}) {
    options.series = choice;
    const auto values = values_of(folder, options);
    ASSERT_TRUE(values.ok()) << outcome(values);
    EXPECT_EQ(values.value().front(), 1000);
  }
  options.series = std::string("9");
  const auto wrong = describe(folder, options);
  EXPECT_EQ(outcome(wrong).find(folder + ": series: expected one of '3' (2 slices, 4 x 3), '7' (3 slices"),
            0u)
      << outcome(wrong);
  EXPECT_EQ(dicom_files(folder).size(), 5u);
}

TEST(DicomSeries, OrientationsAndSizesAreSeriesOfTheirOwn) {
  const std::string folder = new_folder("orientations");
  for (int i = 0; i < 2; ++i) write_dicom(folder + "/a" + std::to_string(i), dicom_slice(i, {0, 0, 2.0 * i}));
  write_dicom(folder + "/b", dicom_slice(5, {0, 0, 0}).text(0x00200037, "DS", "0\\1\\0\\0\\0\\-1"));
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_EQ(d.value().dimensions.z, 2);
  ASSERT_EQ(d.value().series.size(), 2u);
  EXPECT_EQ(d.value().series[0].number, "7.1");
  VolumeOptions options;
  options.series = std::string("7.2");
  EXPECT_EQ(describe(folder, options).value().dimensions.z, 1);

  const std::string sizes = new_folder("sizes");
  write_dicom(sizes + "/a", dicom_slice(1, {0, 0, 0}));
  write_dicom(sizes + "/b", dicom_slice(2, {0, 0, 2}).u16(0x00280010, {2}));
  const auto wrong = describe(sizes);
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(outcome(wrong).find("differ in size (4 x 3 and 4 x 2 pixels)"), std::string::npos)
      << outcome(wrong);
}

TEST(DicomSeries, FramesOfTimeAreToldApart) {
  const std::string folder = new_folder("frames");
  for (int t = 0; t < 3; ++t) {
    for (int z = 0; z < 4; ++z) {
      // Each slice has an acquisition number of its own: that is not what tells the frames apart.
      write_dicom(folder + "/" + std::to_string(t) + std::to_string(z),
                  dicom_slice(10 * t + z, {0, 0, 2.0 * z})
                      .text(0x00180081, "DS", std::to_string(30 - 10 * t))
                      .text(0x00200012, "IS", std::to_string(10 * t + z)));
    }
  }
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_EQ(d.value().frames, 3);
  EXPECT_EQ(d.value().dimensions.z, 4);
  EXPECT_TRUE(says(d.value(), "its 3 frames differ in echo time")) << joined(d.value().remarks);
  VolumeOptions options;
  options.time = 2;
  const auto values = values_of(folder, options);
  ASSERT_TRUE(values.ok()) << outcome(values);
  EXPECT_EQ(values.value().front(), 0) << "the longest echo is the first instance";
  options.time = 3;
  EXPECT_NE(outcome(describe(folder, options)).find("time: expected a frame from 0 to 2, found 3"),
            std::string::npos);
}

TEST(DicomSeries, ASliceThereTwiceIsUsedOnce) {
  const std::string folder = folder_of_slices("twice", {{0, 0, 0}, {0, 0, 2}, {0, 0, 4}, {0, 0, 6}});
  write_dicom(folder + "/again", dicom_slice(3, {0, 0, 4}));
  const auto same = describe(folder);
  ASSERT_TRUE(same.ok()) << outcome(same);
  EXPECT_EQ(same.value().dimensions.z, 4);
  EXPECT_TRUE(says(same.value(), "with the same pixels")) << joined(same.value().remarks);
  write_dicom(folder + "/again", dicom_slice(9, {0, 0, 4}));
  EXPECT_TRUE(says(describe(folder).value(), "with other pixels"))
      << joined(describe(folder).value().remarks);
}

TEST(DicomSeries, ImagesWithoutAPlaceAreStackedByNumber) {
  const std::string folder = new_folder("unplaced");
  for (int i = 0; i < 3; ++i) {
    write_dicom(
        folder + "/" + static_cast<char>('c' - i),
        dicom_slice(i, {0, 0, 0}).without(0x00200032).without(0x00200037).text(0x00180050, "DS", "3"));
  }
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_FALSE(d.value().anatomical);
  EXPECT_EQ(d.value().voxel_to_world, scaling({0.5, 0.75, 3}));
  EXPECT_TRUE(says(d.value(), "does not say where its slices lie")) << joined(d.value().remarks);
  EXPECT_EQ(values_of(folder).value()[12], 100);
}

TEST(DicomSeries, ABrokenFileIsLeftOutAndNamed) {
  const std::string folder = folder_of_slices("broken", {{0, 0, 0}, {0, 0, 2}});
  write_dicom(folder + "/cut.dcm", dicom_slice(3, {0, 0, 4}).element(kPixelData, "OW", "1234"));
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_EQ(d.value().dimensions.z, 2);
  EXPECT_TRUE(says(d.value(), "1 DICOM file is left out: " + folder +
                                  "/cut.dcm: (7FE0,0010) PixelData: expected 24 bytes"))
      << joined(d.value().remarks);
}

TEST(DicomSeries, AScaleThatIsNoNumberIsAnErrorOfAFileAndARemarkOfAFolder) {
  for (const char* text : {"abcd", "0,5", "nan", "inf"}) {
    const std::string folder = folder_of_slices("no_number", {{0, 0, 0}, {0, 0, 2}});
    write_dicom(folder + "/last.dcm", dicom_slice(3, {0, 0, 4}).text(0x00281053, "DS", text));
    const std::string found =
        "(0028,1053) RescaleSlope: expected a number, found '" + std::string(text) + "'";
    EXPECT_NE(outcome(describe(folder + "/last.dcm")).find(found), std::string::npos)
        << outcome(describe(folder + "/last.dcm"));
    const auto d = describe(folder);
    ASSERT_TRUE(d.ok()) << outcome(d);
    EXPECT_EQ(d.value().dimensions.z, 3);
    EXPECT_TRUE(says(d.value(), "1 file has")) << joined(d.value().remarks);
    EXPECT_TRUE(says(d.value(), found + "; 1 is assumed")) << joined(d.value().remarks);
  }
  const std::string empty = temporary_path("no_slope.dcm");
  write_dicom(empty, dicom_slice(1, {0, 0, 0}).text(0x00281053, "DS", "").text(0x00281052, "DS", " "));
  EXPECT_TRUE(describe(empty).ok()) << outcome(describe(empty));
}

TEST(DicomSeries, ValuesBeyondFloatsAreAnError) {
  const std::string path = temporary_path("far_values.dcm");
  write_dicom(path, dicom_slice(1, {0, 0, 0}).text(0x00281052, "DS", "1e308"));
  EXPECT_NE(outcome(describe(path)).find("RescaleIntercept: expected values that fit"), std::string::npos)
      << outcome(describe(path));
  write_dicom(path, dicom_slice(1, {0, 0, 0}).text(0x00281053, "DS", "1e37"));
  EXPECT_NE(outcome(describe(path)).find("RescaleSlope: expected values that fit"), std::string::npos)
      << outcome(describe(path));
}

TEST(DicomSeries, PixelSpacingThatCannotBeUsedIsNamed) {
  const std::string path = temporary_path("no_spacing.dcm");
  for (const char* text : {"0\\0", "-1\\1", "nan\\1", "wide", "0.5", "1e300\\1e300", "1e-300\\1e-300"}) {
    write_dicom(path, dicom_slice(1, {0, 0, 0}).text(0x00280030, "DS", text));
    const auto d = describe(path);
    ASSERT_TRUE(d.ok()) << outcome(d);
    EXPECT_TRUE(
        says(d.value(), "PixelSpacing is not usable (expected two numbers above 0 and below 1e6, found '" +
                            std::string(text) + "'): pixels are taken to be 1 mm wide"))
        << joined(d.value().remarks);
    EXPECT_FALSE(says(d.value(), "no PixelSpacing"));
  }
}

TEST(DicomSeries, PlacesThatNoVolumeCanHaveAreAnError) {
  const std::string path = temporary_path("far.dcm");
  write_dicom(path, dicom_slice(1, {0, 0, 1e300}));
  EXPECT_NE(outcome(describe(path)).find("ImagePositionPatient: expected coordinates up to 1e12 mm"),
            std::string::npos)
      << outcome(describe(path));
  const auto gap = describe(folder_of_slices("far_gap", {{0, 0, 0}, {0, 0, 1}, {0, 0, 1e11}}));
  EXPECT_NE(outcome(gap).find("spacing: expected no axis with more than a million times"), std::string::npos)
      << outcome(gap);
}

TEST(DicomSeries, PixelDataThatIsTooLongIsReported) {
  const std::string folder = folder_of_slices("long", {{0, 0, 0}, {0, 0, 2}});
  write_dicom(folder + "/long.dcm",
              dicom_slice(3, {0, 0, 4}).element(kPixelData, "OW", std::string(30, 'x')));
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_TRUE(says(d.value(), "1 file has more pixel data than Rows x Columns needs: " + folder +
                                  "/long.dcm: 6 bytes are left over"))
      << joined(d.value().remarks);
}

TEST(DicomSeries, WhatASearchDoesNotFollowIsReported) {
  namespace fs = std::filesystem;
  const std::string folder = folder_of_slices("links", {{0, 0, 0}, {0, 0, 2}});
  fs::create_symlink("nowhere", folder + "/dead");
  fs::create_symlink("itself", folder + "/itself");
  fs::create_directory_symlink(".", folder + "/loop");
  fs::create_symlink("z.dcm", folder + "/a_file.dcm");
  const auto d = describe(folder);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_TRUE(says(d.value(), "2 links lead nowhere, the first: ")) << joined(d.value().remarks);
  EXPECT_TRUE(says(d.value(), "1 link to a folder is not followed: " + folder + "/loop"))
      << joined(d.value().remarks);
  EXPECT_TRUE(says(d.value(), "with the same pixels")) << "a link to a file is that file";

  fs::create_directory(folder + "/closed");
  fs::permissions(folder + "/closed", fs::perms::none);
  const auto closed = describe(folder);
  std::error_code error;
  const fs::directory_iterator opened(folder + "/closed", error);
  fs::permissions(folder + "/closed", fs::perms::owner_all);
  // Root may read anything.
  if (!error) return;
  ASSERT_TRUE(closed.ok()) << outcome(closed);
  EXPECT_TRUE(says(closed.value(), "1 folder cannot be read: " + folder + "/closed: Permission denied"))
      << joined(closed.value().remarks);
}

}  // namespace
}  // namespace gvx::io::test
