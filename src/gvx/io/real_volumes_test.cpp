#include <algorithm>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {
namespace {

/// Least and greatest physical value, one slice in memory at a time.
Result<std::pair<double, double>> physical_range(const std::string& path, const VolumeOptions& options = {}) {
  GVX_ASSIGN(const auto reader, open_volume(path, options));
  const VolumeDescription& description = reader->description();
  std::vector<std::byte> slice(slice_bytes(description));
  double least = std::numeric_limits<double>::infinity(), greatest = -least;
  for (std::int64_t z = 0; z < description.dimensions.z; ++z) {
    GVX_TRY(reader->read_slices(1, slice));
    with_sample_type(description.type, [&](auto sample) {
      for (std::size_t at = 0; at < slice.size(); at += sizeof sample) {
        std::memcpy(&sample, slice.data() + at, sizeof sample);
        const double value = description.scale * static_cast<double>(sample) + description.offset;
        least = std::min(least, value);
        greatest = std::max(greatest, value);
      }
    });
  }
  return std::pair(least, greatest);
}

struct Expected {
  const char* path;
  Vec3i dimensions;
  SampleType type;
  Vec3d spacing;
  double least, greatest;
};

TEST(RealVolumes, shapes_spacings_and_physical_ranges) {
  GVX_NEED_TEST_DATA(data);
  const Expected all[] = {
      {"volumes/nifti/marc_avf_float32.nii.gz",
       {74, 93, 20},
       SampleType::f32,
       {0.72, 0.72, 1},
       0,
       2509.886962890625},
      {"volumes/nifti/osv_bonsai.nii.gz", {256, 256, 256}, SampleType::u8, {1, 1, 1}, 0, 255},
      {"volumes/nifti/osv_engine.nii.gz", {256, 256, 128}, SampleType::u8, {1, 1, 1}, 0, 255},
      {"volumes/nifti/stroke_T1.nii.gz", {124, 160, 140}, SampleType::u8, {1, 1, 1}, 0, 252},
      {"volumes/niivue_formats/MNI152_2009_template.nii.gz",
       {193, 229, 193},
       SampleType::i16,
       {1, 1, 1},
       0,
       1570},
      {"volumes/niivue_formats/shear.nii.gz",
       {306, 422, 54},
       SampleType::u8,
       {0.48, 0.48, 2.37},
       -1024,
       789.0000591278076},
      {"volumes/niivue_formats/spmMotor.nii.gz",
       {79, 95, 79},
       SampleType::i16,
       {2, 2, 2},
       -6.862357426900417,
       12.156504611950368},
      {"volumes/raw/hydrogenAtom_128x128x128_u8.raw", {128, 128, 128}, SampleType::u8, {1, 1, 1}, 0, 250},
  };
  for (const Expected& expected : all) {
    const auto description = describe(data + expected.path);
    ASSERT_TRUE(description.ok()) << outcome(description);
    EXPECT_EQ(description.value().dimensions, expected.dimensions) << expected.path;
    EXPECT_EQ(description.value().type, expected.type) << expected.path;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(length(description.value().voxel_to_world.column[axis]), expected.spacing[axis], 0.01)
          << expected.path;
    }
    const auto range = physical_range(data + expected.path);
    ASSERT_TRUE(range.ok()) << outcome(range);
    EXPECT_DOUBLE_EQ(range.value().first, expected.least) << expected.path;
    EXPECT_DOUBLE_EQ(range.value().second, expected.greatest) << expected.path;
  }
}

TEST(RealVolumes, nrrd_and_meta_image_shapes) {
  GVX_NEED_TEST_DATA(data);
  const std::pair<const char*, Vec3i> all[] = {
      {"volumes/nrrd/itk_Input-RA-Short.nrrd", {64, 64, 64}},
      {"volumes/nrrd/nucleon.nrrd", {41, 41, 41}},
      {"volumes/niivue_formats/FLAIR.nrrd", {124, 160, 140}},
      {"volumes/metaimage/HeadMRVolume.mha", {48, 62, 42}},
      {"volumes/metaimage/HeadMRVolume.mhd", {48, 62, 42}},
  };
  for (const auto& [path, dimensions] : all) {
    const auto description = describe(data + path);
    ASSERT_TRUE(description.ok()) << outcome(description);
    EXPECT_EQ(description.value().dimensions, dimensions) << path;
    const auto range = physical_range(data + path);
    ASSERT_TRUE(range.ok()) << outcome(range);
    EXPECT_LT(range.value().first, range.value().second) << path;
  }
  const auto attached = load(data + "volumes/metaimage/HeadMRVolume.mha");
  const auto detached = load(data + "volumes/metaimage/HeadMRVolume.mhd");
  ASSERT_TRUE(attached.ok() && detached.ok());
  EXPECT_EQ(attached.value(), detached.value());
}

TEST(RealVolumes, same_patient_in_nrrd_and_nifti) {
  GVX_NEED_TEST_DATA(data);
  // Two scans of one grid: the one file says it in LPS, the other in RAS.
  const auto nrrd = describe(data + "volumes/niivue_formats/FLAIR.nrrd");
  const auto nifti = describe(data + "volumes/nifti/stroke_T1.nii.gz");
  ASSERT_TRUE(nrrd.ok() && nifti.ok());
  ASSERT_EQ(nrrd.value().dimensions, nifti.value().dimensions);
  EXPECT_TRUE(nrrd.value().anatomical && nifti.value().anatomical);
  for (const Vec3d corner : {Vec3d(0, 0, 0), Vec3d(124, 160, 140)}) {
    const Vec3d difference =
        nrrd.value().voxel_to_world.point(corner) - nifti.value().voxel_to_world.point(corner);
    EXPECT_NEAR(length(difference), 0, 0.01);
  }
}

TEST(RealVolumes, colours_are_read_and_complex_numbers_refused) {
  GVX_NEED_TEST_DATA(data);
  const auto colours = describe(data + "volumes/niivue_formats/ct_perfusion.nii.gz");
  ASSERT_TRUE(colours.ok()) << outcome(colours);
  EXPECT_TRUE(colours.value().colors);
  EXPECT_EQ(colours.value().components, 3);
  const auto complex = describe(data + "volumes/niivue_formats/complex.nii.gz");
  EXPECT_NE(outcome(complex).find("(complex numbers)"), std::string::npos) << outcome(complex);
}

TEST(RealVolumes, every_encoding_of_one_ball_holds_the_same_voxels) {
  GVX_NEED_TEST_DATA(data);
  const std::string folder = data + "malformed/pynrrd_tests/BallBinary30x30x30";
  const auto ball = load(folder + ".nrrd");
  ASSERT_TRUE(ball.ok()) << outcome(ball);
  EXPECT_EQ(ball.value().size(), 54000u);
  EXPECT_NE(ball.value(), std::string(54000, '\0'));
  for (const char* name :
       {".nhdr", "_bz2.nrrd", "_gz.nrrd", "_gz_lineskip.nrrd", "_gz_byteskip_minus_one.nrrd",
        "_byteskip_minus_one.nhdr", "_byteskip_minus_one_nifti.nhdr", ".nii.gz"}) {
    const auto other = load(folder + name);
    ASSERT_TRUE(other.ok()) << outcome(other);
    EXPECT_EQ(other.value(), ball.value()) << name;
  }
  EXPECT_FALSE(load(folder + "_byteskip_minus_five.nhdr").ok());
}

TEST(RealVolumes, files_that_once_crashed_readers) {
  GVX_NEED_TEST_DATA(data);
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(data + "malformed")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const auto as_it_is = load(entry.path().string());
    if (!as_it_is.ok()) {
      EXPECT_NE(as_it_is.error().message.find(": "), std::string::npos);
    }
    // And as each format, whatever it is.
    const std::string bytes = read_file(entry.path().string());
    for (const char* extension : {".nrrd", ".mha", ".nii", "_2x2x2_u8.raw.gz", "_2x2x2_u8.raw.bz2"}) {
      const std::string path = temporary_path(std::string("malformed") + extension);
      write_file(path, bytes);
      const auto samples = load(path);
      if (samples.ok()) {
        EXPECT_TRUE(entry.path().string().ends_with(".nrrd") || entry.path().string().ends_with(".nii.gz"))
            << entry.path() << " was read as " << extension;
      }
    }
  }
  EXPECT_GT(files, 100);
}

}  // namespace
}  // namespace gvx::io::test
