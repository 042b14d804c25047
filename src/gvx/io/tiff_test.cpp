#include "gvx/io/tiff.h"

#include <filesystem>

#include "gvx/io/tiff_names.h"
#include "gvx/io/tiff_samples.h"
#include "gvx/io/tiff_test_support.h"

namespace gvx::io::test {
namespace {

TEST(Tiff, PagesOfEverySampleTypeAreSlices) {
  const std::string path = temporary_path("types.tif");
  for (const SampleType type : kAllSampleTypes) {
    for (const char* mode : {"wl", "wb", "wl8", "wb8"}) {
      write_tiff(path, small_pages(type), mode);
      const auto d = describe(path);
      ASSERT_TRUE(d.ok()) << outcome(d);
      EXPECT_EQ(d.value().dimensions, kSmallDimensions);
      EXPECT_EQ(d.value().type, type);
      EXPECT_EQ(d.value().remarks.size(), 0u);
      const auto samples = load(path);
      ASSERT_TRUE(samples.ok()) << outcome(samples);
      EXPECT_EQ(samples.value(), native_small_samples(type)) << sample_name(type) << " " << mode;
    }
  }
}

TEST(Tiff, CompressionsPredictorsAndTilesHoldTheSameSamples) {
  const std::string path = temporary_path("compressed.tif");
  struct Case {
    SampleType type;
    int compression, predictor;
  };
  for (const Case& c : {Case{SampleType::u16, COMPRESSION_PACKBITS, 1},
                        {SampleType::u16, COMPRESSION_LZW, 1},
                        {SampleType::u16, COMPRESSION_LZW, 2},
                        {SampleType::i32, COMPRESSION_LZW, 2},
                        {SampleType::u16, COMPRESSION_ADOBE_DEFLATE, 2},
                        {SampleType::f32, COMPRESSION_ADOBE_DEFLATE, 3},
                        {SampleType::f64, COMPRESSION_DEFLATE, 3},
                        {SampleType::u16, COMPRESSION_ZSTD, 1},
                        {SampleType::u16, COMPRESSION_LZMA, 1}}) {
    if (TIFFIsCODECConfigured(static_cast<std::uint16_t>(c.compression)) != 1) continue;
    for (const bool tiled : {false, true}) {
      for (const char* mode : {"wl", "wb"}) {
        // libtiff 4.5 may write the bytes of big-endian doubles in the wrong order.
        if (c.predictor == 3 && mode[1] == 'b') continue;
        write_tiff(path,
                   small_pages(c.type,
                               [&](TIFF* tiff) {
                                 TIFFSetField(tiff, TIFFTAG_COMPRESSION, c.compression);
                                 if (c.predictor > 1) TIFFSetField(tiff, TIFFTAG_PREDICTOR, c.predictor);
                                 if (tiled)
                                   TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 32),
                                       TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
                               }),
                   mode);
        const auto samples = load(path);
        ASSERT_TRUE(samples.ok()) << outcome(samples);
        EXPECT_EQ(samples.value(), native_small_samples(c.type)) << c.compression << " " << tiled << mode;
      }
    }
  }
}

TEST(Tiff, SamplesOfOddSizesAreUnpacked) {
  const std::string path = temporary_path("bits.tif");
  const auto page = [&](int bits, const std::string& bytes, int format = SAMPLEFORMAT_UINT) {
    TestPage one{.width = 3, .height = 1, .bytes = bytes};
    one.more = [=](TIFF* tiff) {
      TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
      TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, format);
    };
    write_tiff(path, {one}, "wl");
    return load(path).value();
  };
  EXPECT_EQ(page(1, "\xA0"), std::string("\1\0\1", 3));
  EXPECT_EQ(page(4, "\x1F\x70"), "\x1\xF\x7");
  EXPECT_EQ(page(4, "\x1F\x70", SAMPLEFORMAT_INT), "\x1\xFF\x7");
  // 12 bits: 0x123, 0xFFF, 0x456.
  EXPECT_EQ(page(12, "\x12\x3F\xFF\x45\x60"), std::string("\x23\x01\xFF\x0F\x56\x04", 6));
  const std::string halves = page(16, std::string("\x00\x3C\x00\xC0\x01\x00", 6), SAMPLEFORMAT_IEEEFP);
  ASSERT_EQ(halves.size(), 12u);
  float values[3];
  std::memcpy(values, halves.data(), 12);
  EXPECT_EQ(values[0], 1.0f);
  EXPECT_EQ(values[1], -2.0f);
  EXPECT_EQ(values[2], 0x1p-24f);
  EXPECT_TRUE(std::isinf(half_to_float(0x7C00)) && std::isnan(half_to_float(0x7E00)));
}

TEST(Tiff, ColoursAndChannelsOfAPixel) {
  const std::string path = temporary_path("colours.tif");
  std::string bytes;
  for (int i = 0; i < 36; ++i) bytes += static_cast<char>(i);
  const auto rgb = [](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB); };
  write_tiff(path, {{.samples = 3, .bytes = bytes, .more = rgb}});
  VolumeDescription d = describe(path).value();
  EXPECT_TRUE(d.colors);
  EXPECT_EQ(d.components, 3);
  EXPECT_EQ(load(path).value(), bytes);

  // The same with each colour in a plane of its own.
  std::string planes;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = c; i < 36; i += 3) planes += bytes[i];
  }
  write_tiff(path, {{.samples = 3, .bytes = planes, .more = [&](TIFF* tiff) {
                       rgb(tiff);
                       TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_SEPARATE);
                     }}});
  EXPECT_EQ(load(path).value(), bytes);

  write_tiff(path, {{.type = SampleType::u16, .samples = 3, .bytes = bytes + bytes, .more = rgb}}, "wl");
  d = describe(path).value();
  EXPECT_FALSE(d.colors);
  ASSERT_EQ(d.channels.size(), 3u);
  EXPECT_EQ(d.channels[1].name, "green");
  EXPECT_EQ(load(path).value(), bytes + bytes);

  // Gray with an opacity, which is dropped.
  write_tiff(path, {{.samples = 3, .bytes = bytes, .more = [](TIFF* tiff) {
                       const std::uint16_t extra[] = {EXTRASAMPLE_UNSPECIFIED, EXTRASAMPLE_UNASSALPHA};
                       TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 2, extra);
                     }}});
  d = describe(path).value();
  EXPECT_EQ(d.components, 2);
  expect_text(remarks_of(path), "alpha");
  EXPECT_EQ(load(path).value().substr(0, 6), std::string("\0\1\3\4\6\7", 6));

  write_tiff(path, {{.samples = 6, .bytes = bytes + bytes}});
  EXPECT_EQ(describe(path).value().components, 4);
  expect_text(remarks_of(path), "has 6 channels; the first 4 are read");
  EXPECT_EQ(load(path).value().substr(0, 6), std::string("\0\1\2\3\6\7", 6));

  write_tiff(path, {{.bytes = bytes.substr(0, 12), .more = [](TIFF* tiff) {
                       TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISWHITE);
                     }}});
  expect_text(remarks_of(path), "MinIsWhite");
  EXPECT_EQ(load(path).value(), bytes.substr(0, 12));
  write_tiff(path, {{.samples = 4, .bytes = bytes + bytes.substr(0, 12), .more = [](TIFF* tiff) {
                       TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_SEPARATED);
                     }}});
  expect_text(outcome(load(path)), "expected gray, RGB or palette, found CMYK");
}

TEST(Tiff, LevelsAreNoSlices) {
  const std::string path = temporary_path("levels.tif");
  const TestPage full{.width = 8, .height = 6, .bytes = std::string(48, 'f')};
  TestPage half{.width = 4, .height = 3, .bytes = std::string(12, 'h')};
  write_tiff(path, {full, half});
  EXPECT_EQ(describe(path).value().dimensions, Vec3i(8, 6, 1));
  expect_text(remarks_of(path), "1 page is a smaller copy");
  // Pages of one pixel are no copies of each other.
  write_tiff(path, {{.width = 1, .height = 1, .bytes = "a"}, {.width = 1, .height = 1, .bytes = "b"}});
  EXPECT_EQ(first_samples(path), "ab");
  // Of any size where the page says what it is.
  TestPage marked{.width = 7, .height = 1, .bytes = "thumb!!", .more = [](TIFF* tiff) {
                    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
                  }};
  write_tiff(path, {marked, full, half, full, half});
  EXPECT_EQ(first_samples(path), "ff");
  // SubIFDs: the pages after one that names them.
  TestPage parent = full;
  parent.more = [](TIFF* tiff) {
    const toff_t none[1] = {0};
    TIFFSetField(tiff, TIFFTAG_SUBIFD, 1, none);
  };
  write_tiff(path, {parent, half, full});
  EXPECT_EQ(first_samples(path), "ff");
  EXPECT_EQ(remarks_of(path), "");
}

TEST(Tiff, PagesOfOtherShapesAreErrorsThatNameThePage) {
  const std::string path = temporary_path("shapes.tif");
  const TestPage page{.bytes = std::string(12, 'p')};
  write_tiff(path, {page, page, {.width = 4, .height = 2, .bytes = "12345678"}});
  expect_text(outcome(describe(path)),
              "page 3: expected 4 x 3 pixels of u8 as page 1 has, found 4 x 2 pixels of u8");
  write_tiff(path, {page, {.type = SampleType::u16, .bytes = std::string(24, 'p')}});
  expect_text(outcome(describe(path)), "page 2: expected 4 x 3 pixels of u8");
}

TEST(Tiff, FoldersAndPatternsInTheOrderOfTheirNumbers) {
  const std::string folder = temporary_path("slices");
  std::filesystem::create_directories(folder);
  for (int i = 0; i < 12; ++i) {
    write_tiff(folder + "/slice_" + std::to_string(i) + ".tif",
               flat_pages(std::string(1, static_cast<char>('a' + i))));
  }
  write_file(folder + "/notes.txt", "no slice");
  write_file(folder + "/._slice_1.tif", "no slice");
  EXPECT_EQ(first_samples(folder), "abcdefghijkl");
  EXPECT_EQ(first_samples(folder + "/slice_1*.tif"), "bkl");
  EXPECT_EQ(first_samples(folder + "/slice_%03d.tif"), "abcdefghijkl");
  EXPECT_EQ(first_samples(folder + "/*_?.tif"), "abcdefghij");
  const auto files = volume_files(folder, {});
  EXPECT_EQ(files.size(), 13u);
  EXPECT_EQ(files.back(), folder + "/slice_11.tif");
  expect_text(outcome(describe(folder + "/x*.tif")), "expected TIFF files (.tif, .tiff), found none");

  write_tiff(folder + "/slice_7.tif", {{.width = 5, .height = 3, .bytes = std::string(15, 'x')}});
  const std::string message = outcome(describe(folder));
  expect_text(message,
              "slice_7.tif: expected 4 x 3 pixels of u8 as " + folder + "/slice_0.tif has, found 5 x 3");
  write_tiff(folder + "/slice_7.tif", flat_pages("xy"));
  expect_text(outcome(describe(folder)),
              "expected files of one slice each, but " + folder + "/slice_7.tif has 2");

  EXPECT_TRUE(in_natural_order("a2", "a10") && in_natural_order("a02b", "a2c") &&
              in_natural_order("a", "ab"));
  EXPECT_TRUE(in_natural_order("a007", "a7") != in_natural_order("a7", "a007"));
  EXPECT_FALSE(in_natural_order("a7", "a7"));
}

TEST(Tiff, NamesThatAreNoFilesAndGapsInNumbersAreNamed) {
  const std::string folder = temporary_path("slices_with_gaps");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder + "/z4.tif");
  expect_text(outcome(describe(folder + "/*.tif")), "found none but z4.tif (a folder, a pipe");
  for (const int i : {1, 2, 3, 10}) write_tiff(folder + "/z" + std::to_string(i) + ".tif", flat_pages("a"));
  std::filesystem::create_symlink("nowhere.tif", folder + "/z5.tif");
  std::filesystem::create_directory_symlink("z4.tif", folder + "/z11.tif");
  expect_text(remarks_of(folder), "left out: z4.tif and 2 others (a folder, a pipe");
  expect_text(remarks_of(folder),
              "numbers are missing between z3.tif and z10.tif; the slices are read as neighbours");
  EXPECT_EQ(describe(folder).value().dimensions.z, 4);

  EXPECT_EQ(gaps_in_numbers({"z1.tif", "z2.tif", "z03.tif"}), "");
  EXPECT_EQ(gaps_in_numbers({"z0.tif", "z10.tif", "z20.tif"}), "");
  EXPECT_EQ(gaps_in_numbers({"c1_z1.tif", "c1_z2.tif", "c5_z1.tif", "c5_z2.tif"}), "");
  EXPECT_EQ(gaps_in_numbers({"a.tif", "b.tif", "z99999999999999999999.tif"}), "");
  expect_text(gaps_in_numbers({"z8.tif", "z09.tif", "z12.tif", "z13.tif", "z15.tif"}),
              "between z09.tif and z12.tif and in 1 other place;");
}

TEST(Tiff, OptionsThatDoNotApply) {
  const std::string path = temporary_path("options.tif");
  write_tiff(path, flat_pages("ab"));
  VolumeOptions options;
  options.time = 1;
  expect_text(outcome(describe(path, options)), "time: the volume does not change with time");
  options = {};
  options.series = "1";
  expect_text(outcome(describe(path, options)), "series:");
  options = {};
  options.raw.type = SampleType::u8;
  expect_text(outcome(describe(path, options)), "describes itself");
  options = {};
  options.raw.spacing = Vec3d(1, 2, 3);
  EXPECT_EQ(length(describe(path, options).value().voxel_to_world.column[2]), 3);
  EXPECT_TRUE(is_tiff(path));
  // Known by its content too.
  std::filesystem::copy_file(path, temporary_path("options_without_extension"),
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_EQ(first_samples(temporary_path("options_without_extension")), "ab");
}

}  // namespace
}  // namespace gvx::io::test
