// TIFF files that are cut short, broken or made to hurt, and real ones of others.

#include <filesystem>
#include <random>

#include "gvx/io/tiff_test_support.h"

namespace gvx::io::test {
namespace {

constexpr std::uint64_t kMostBytes = 1 << 20;

/// Small files of each kind.
std::vector<std::string> specimens() {
  const std::string path = temporary_path("specimen.tif");
  std::vector<std::string> files;
  const auto add = [&](const std::vector<TestPage>& pages, const char* mode) {
    write_tiff(path, pages, mode);
    files.push_back(read_file(path));
  };
  const auto packed = [](int compression) {
    return [=](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression); };
  };
  add(small_pages(SampleType::i16), "wb");
  add(small_pages(SampleType::i16), "wl8");
  add(small_pages(SampleType::i16, packed(COMPRESSION_LZW)), "wl");
  add(small_pages(SampleType::i16, packed(COMPRESSION_ADOBE_DEFLATE)), "wb");
  add(small_pages(SampleType::i16, packed(COMPRESSION_PACKBITS)), "wl");
  add(small_pages(SampleType::i16,
                  [](TIFF* tiff) {
                    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
                    TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
                  }),
      "wl");
  add(flat_pages("abcd", "ImageJ=1.53t\nimages=4\nslices=2\nframes=2\nspacing=2\nunit=um\n"), "wl");
  add(flat_pages("ab",
                 "<OME><Image><Pixels SizeX=\"4\" SizeY=\"3\" SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\" "
                 "DimensionOrder=\"XYZCT\"><TiffData FirstZ=\"1\" IFD=\"0\"/><TiffData IFD=\"1\"/></Pixels>"
                 "</Image></OME>"),
      "wl");
  return files;
}

TEST(TiffHostile, EveryTruncationIsAnErrorOrTheSamples) {
  const std::string path = temporary_path("truncated.tif");
  for (const std::string& good : specimens()) {
    write_file(path, good);
    const auto whole = load(path);
    ASSERT_TRUE(whole.ok()) << outcome(whole);
    int errors = 0;
    for (std::size_t size = 0; size < good.size(); ++size) {
      write_file(path, good.substr(0, size));
      const auto samples = load(path, {}, kMostBytes);
      if (samples.ok()) {
        EXPECT_EQ(samples.value(), whole.value()) << "cut to " << size;
      } else {
        ++errors;
        EXPECT_EQ(samples.error().message.rfind(path, 0), 0u) << samples.error().message;
        EXPECT_EQ(samples.error().message.find('\n'), std::string::npos) << samples.error().message;
      }
    }
    EXPECT_GE(errors, static_cast<int>(good.size()) - 16);
  }
}

TEST(TiffHostile, FlippedBitsNeverBreakTheReader) {
  std::mt19937 random(20261130);
  const std::string path = temporary_path("flipped.tif");
  int errors = 0, successes = 0;
  for (const std::string& good : specimens()) {
    for (int round = 0; round < 250; ++round) {
      std::string bytes = good;
      for (int flip = 0; flip <= round % 4; ++flip) {
        char& c = bytes[random() % bytes.size()];
        c = static_cast<char>(round % 3 == 0 ? random() : static_cast<unsigned>(c) ^ (1u << random() % 8));
      }
      write_file(path, bytes);
      const auto samples = load(path, {}, kMostBytes);
      ++(samples.ok() ? successes : errors);
      if (!samples.ok()) {
        EXPECT_EQ(samples.error().message.find('\n'), std::string::npos) << samples.error().message;
      }
    }
  }
  EXPECT_GT(errors, 200);
  EXPECT_GT(successes, 200);
}

TEST(TiffHostile, SizesThatTheFileCannotHoldAreErrors) {
  const std::string path = temporary_path("absurd.tif");
  write_tiff(path,
             {{.bytes = std::string(12, 'x'),
               .more = [](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 3); }}},
             "wl");
  const std::string good = read_file(path);
  const std::size_t width =
      good.find(bytes_of(std::uint16_t{256}, false) + bytes_of(std::uint16_t{3}, false));
  ASSERT_NE(width, std::string::npos);
  std::string bytes = good;
  bytes.replace(width + 2, 10,
                bytes_of(std::uint16_t{4}, false) + bytes_of(std::uint32_t{1}, false) +
                    bytes_of(std::uint32_t{0x7FFFFFFF}, false));
  write_file(path, bytes);
  expect_text(outcome(describe(path)), "absurd.tif: ");
  EXPECT_FALSE(describe(path).ok());
  // The list of pages as a loop.
  bytes = good;
  const auto first = bytes.substr(4, 4);
  bytes.replace(bytes.size() - 4, 4, first);
  write_file(path, bytes);
  EXPECT_FALSE(describe(path).ok());
  write_file(path, std::string("II*\0\0\0\0\0", 8));
  expect_text(outcome(describe(path)), "expected a TIFF file with at least one page, found none");
  write_file(path, "GIF89a");
  expect_text(outcome(describe(path)), "not a TIFF file");
}

TEST(TiffHostile, FaultsOfAPageNameThePageAndTheTag) {
  const std::string path = temporary_path("fault.tif");
  write_tiff(path, flat_pages("ab"), "wl");
  const std::string good = read_file(path);
  // The last directory is that of page 2.
  const auto with_field = [&](std::uint16_t tag, std::uint16_t new_tag, std::uint32_t value) {
    std::string bytes = good;
    const std::size_t last =
        good.rfind(bytes_of(std::uint16_t{256}, false) + bytes_of(std::uint16_t{3}, false));
    const std::size_t at = good.find(bytes_of(tag, false), last);
    EXPECT_NE(at, std::string::npos);
    bytes.replace(at, 2, bytes_of(new_tag, false));
    bytes.replace(at + 8, 4, bytes_of(value, false));
    write_file(path, bytes);
    return outcome(describe(path));
  };
  const auto expect_fault = [](const std::string& message, const std::string& part) {
    expect_text(message, "page 2: ");
    expect_text(message, part);
    EXPECT_EQ(message.find("list of pages"), std::string::npos) << message;
  };
  expect_fault(with_field(277, 277, 0), "SamplesPerPixel");
  expect_fault(with_field(256, 256, 0), "ImageWidth");
  expect_fault(with_field(339, 339, 99), "SampleFormat");
  expect_fault(with_field(278, 278, 0), "RowsPerStrip");
  expect_fault(with_field(284, 284, 9), "PlanarConfig");
  expect_fault(with_field(273, 65000, 0), "StripOffsets");

  std::string bytes = good;
  write_tiff(path,
             {{.bytes = std::string(12, 'x'),
               .more = [](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 3); }}},
             "wl");
  bytes = read_file(path);
  const std::size_t offset =
      bytes.find(bytes_of(std::uint16_t{273}, false) + bytes_of(std::uint16_t{4}, false));
  ASSERT_NE(offset, std::string::npos);
  bytes.replace(offset + 8, 4, bytes_of(std::uint32_t{0}, false));
  write_file(path, bytes);
  expect_text(outcome(describe(path)), "begins at byte 0, within the header of the file (StripOffsets)");
}

TEST(TiffHostile, FilesThatOnceCrashedReaders) {
  if (data_folder().empty()) GTEST_SKIP() << "set GVX_TEST_DATA to the folder with third-party test data";
  int files = 0, good = 0;
  for (const auto& entry : std::filesystem::directory_iterator(data_folder() + "malformed/libtiff_images")) {
    const std::string path = entry.path().string();
    if (!path.ends_with(".tif") && !path.ends_with(".tiff")) continue;
    ++files;
    const auto samples = load(path, {}, 1 << 26);
    good += samples.ok() ? 1 : 0;
    EXPECT_EQ(outcome(samples).find('\n'), std::string::npos) << outcome(samples);
    const std::string bytes = read_file(path), cut = temporary_path("cut.tif");
    for (int part = 1; part < 16; ++part) {
      write_file(cut, bytes.substr(0, bytes.size() * static_cast<std::size_t>(part) / 16));
      const auto shorter = load(cut, {}, 1 << 26);
      EXPECT_EQ(outcome(shorter).find('\n'), std::string::npos) << outcome(shorter);
    }
  }
  EXPECT_GT(files, 15);
  EXPECT_GT(good, 10);
}

TEST(RealTiffs, ShapesTypesAndRemarks) {
  if (data_folder().empty()) GTEST_SKIP() << "set GVX_TEST_DATA to the folder with third-party test data";
  const std::string folder = data_folder() + "formats/ome-tiff/";
  struct Expected {
    std::string path;
    Vec3i dimensions;
    SampleType type;
    int components;
  };
  for (const Expected& e :
       {Expected{folder + "itk_single-channel.ome.tif", {439, 167, 1}, SampleType::u8, 1},
        {folder + "itk_cthead1-multires.tif", {256, 256, 1}, SampleType::u8, 1},
        {folder + "viv/multi-channel.ome.tif", {439, 167, 1}, SampleType::i8, 3},
        {folder + "viv/multifile-Z*.ome.tiff", {18, 24, 5}, SampleType::u8, 1},
        {folder + "viv/Channel_0.tif", {439, 167, 1}, SampleType::u8, 1},
        {data_folder() + "volumes/tiff/cellfinder_brain", {271, 193, 270}, SampleType::u16, 1}}) {
    const auto d = describe(e.path);
    ASSERT_TRUE(d.ok()) << outcome(d);
    EXPECT_EQ(d.value().dimensions, e.dimensions) << e.path;
    EXPECT_EQ(d.value().type, e.type) << e.path;
    EXPECT_EQ(d.value().components, e.components) << e.path;
  }
  expect_text(remarks_of(folder + "itk_cthead1-multires.tif"), "2 pages are smaller copies");
  const auto brain = load(data_folder() + "volumes/tiff/cellfinder_brain");
  ASSERT_TRUE(brain.ok()) << outcome(brain);
  std::uint16_t greatest = 0;
  for (std::size_t at = 0; at < brain.value().size(); at += 2) {
    std::uint16_t sample = 0;
    std::memcpy(&sample, brain.value().data() + at, 2);
    greatest = std::max(greatest, sample);
  }
  EXPECT_EQ(greatest, 14580);
}

}  // namespace
}  // namespace gvx::io::test
