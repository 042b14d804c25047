// Hyperstacks: what OME-XML and ImageJ say of pages.

#include <filesystem>

#include "gvx/io/ome_xml.h"
#include "gvx/io/tiff_test_support.h"

namespace gvx::io::test {
namespace {

Vec3d spacing_of(const VolumeDescription& d) {
  const Affine3& a = d.voxel_to_world;
  return {length(a.column[0]), length(a.column[1]), length(a.column[2])};
}

VolumeOptions at_time(std::int64_t time) {
  VolumeOptions options;
  options.time = time;
  return options;
}

/// 4 x 3 pixels of u8.
std::string ome(const std::string& pixels, const std::string& inside, const std::string& root = "") {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?><!-- c --><OME " + root +
         "><Image ID=\"Image:0\" Name=\"one\"><Pixels ID=\"Pixels:0\" Type=\"uint8\" SizeX=\"4\" "
         "SizeY=\"3\" " +
         pixels + ">" + inside + "</Pixels></Image></OME>";
}

TEST(TiffImageJ, HyperstacksHaveChannelsSlicesAndFrames) {
  const std::string path = temporary_path("hyperstack.tif");
  // Channels fastest, then slices, then frames.
  auto pages = flat_pages("aAbBcCdD",
                          "ImageJ=1.53t\nimages=8\nchannels=2\nslices=2\nframes=2\nunit=micron\nspacing=2.5\n"
                          "xorigin=4\n");
  pages.front().more = [](TIFF* tiff) {
    TIFFSetField(tiff, TIFFTAG_XRESOLUTION, 2.0);
    TIFFSetField(tiff, TIFFTAG_YRESOLUTION, 4.0);
    TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_NONE);
  };
  write_tiff(path, pages);
  const VolumeDescription d = describe(path).value();
  EXPECT_EQ(d.dimensions, Vec3i(4, 3, 2));
  EXPECT_EQ(d.components, 2);
  EXPECT_EQ(d.frames, 2);
  EXPECT_EQ(d.frame, 0);
  EXPECT_EQ(spacing_of(d), Vec3d(0.5, 0.25, 2.5));
  EXPECT_NEAR(length(d.voxel_to_world.point({4.5, 0.5, 0.5})), 0, 1e-12);
  EXPECT_EQ(d.unit, "\xC2\xB5m");
  expect_text(remarks_of(path), "has 2 frames in time; the first is read (--time 0 to 1 chooses one)");
  EXPECT_EQ(load(path).value().substr(0, 4), "aAaA");
  EXPECT_EQ(first_samples(path), "ab");
  EXPECT_EQ(first_samples(path, at_time(1)), "cd");
  EXPECT_EQ(remarks_of(path, at_time(1)), "");
  expect_text(outcome(describe(path, at_time(2))), "time: expected a frame from 0 to 1, found 2");

  write_tiff(path, flat_pages("abc", "ImageJ=1.53t\nimages=8\nchannels=2\nslices=2\nframes=2\n"));
  EXPECT_EQ(first_samples(path), "abc");
  expect_text(remarks_of(path), "speaks of 8 images, but the file has 3");
  write_tiff(path, flat_pages("abcdef", "ImageJ=1.53t\nimages=6\nslices=12\n"));
  expect_text(remarks_of(path), "is 1 x 12 x 1, which is not the number of images, 6; its pages");
}

TEST(TiffImageJ, LargeStacksHaveOneDirectory) {
  const std::string path = temporary_path("one_directory.tif");
  for (const char* mode : {"wl", "wb"}) {
    const bool big = mode[1] == 'b';
    std::vector<TestPage> pages = small_pages(SampleType::u16);
    pages.resize(1);
    pages.front().description = "ImageJ=1.53t\nimages=3\nslices=3\n";
    pages.front().more = [](TIFF* tiff) { TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 3); };
    write_tiff(path, pages, mode);
    // libtiff puts the samples first; the others must follow them.
    std::string bytes = read_file(path);
    const std::string first = small_samples(SampleType::u16, big).substr(0, 24);
    const std::size_t at = bytes.find(first);
    ASSERT_EQ(at, 8u);
    const std::string moved = bytes_of(static_cast<std::uint32_t>(bytes.size()), big);
    // To the end of the file: the strip's offset is the one field that holds 8.
    const std::string strip_offset = bytes_of(std::uint16_t{273}, big);
    const std::size_t entry = bytes.find(strip_offset, 32);
    ASSERT_NE(entry, std::string::npos);
    bytes.replace(entry + 8, 4, moved);
    bytes += first + small_samples(SampleType::u16, big).substr(24, 24) + first;
    write_file(path, bytes);
    const auto samples = load(path);
    ASSERT_TRUE(samples.ok()) << outcome(samples);
    const std::string native = native_small_samples(SampleType::u16);
    EXPECT_EQ(samples.value(), native + native.substr(0, 24)) << mode;
    write_file(path, bytes.substr(0, bytes.size() - 1));
    expect_text(outcome(describe(path)), "expected 3 images, found the samples of 2");
  }
}

TEST(TiffImageJ, CalibrationIsAValueScale) {
  const std::string path = temporary_path("calibrated.tif");
  write_tiff(path, flat_pages("a", "ImageJ=1.53t\ncf=0\nc0=-32768\nc1=2\nvunit=HU\n"));
  EXPECT_EQ(describe(path).value().offset, -32768);
  EXPECT_EQ(describe(path).value().scale, 2);
}

TEST(TiffOme, PlanesFollowTheDimensionOrder) {
  const std::string path = temporary_path("order.ome.tif");
  const std::string sizes = "SizeZ=\"2\" SizeC=\"2\" SizeT=\"2\" DimensionOrder=";
  write_tiff(path, flat_pages("abABcdCD", ome(sizes + "\"XYZCT\"", "<TiffData/>")));
  EXPECT_EQ(load(path).value().substr(0, 2), "aA");
  EXPECT_EQ(first_samples(path), "ab");
  EXPECT_EQ(first_samples(path, at_time(1)), "cd");
  write_tiff(path, flat_pages("acACbdBD", ome(sizes + "\"XYTCZ\"", "")));
  EXPECT_EQ(load(path).value().substr(0, 2), "aA");
  EXPECT_EQ(first_samples(path), "ab");
  EXPECT_EQ(first_samples(path, at_time(1)), "cd");
  EXPECT_EQ(describe(path).value().frames, 2);
  write_tiff(path, flat_pages("a", ome(sizes + "\"XYZ\"", "")));
  expect_text(outcome(describe(path)), "DimensionOrder: expected XY and then C, T and Z");
}

TEST(TiffOme, PagesInAnyOrderAndMissingPlanes) {
  const std::string path = temporary_path("reversed.ome.tif");
  std::string data;
  for (int z = 0; z < 3; ++z) {
    data += "<TiffData FirstZ=\"" + std::to_string(z) + "\" IFD=\"" + std::to_string(2 - z) +
            "\" PlaneCount=\"1\"/>";
  }
  write_tiff(path,
             flat_pages("cba", ome("SizeZ=\"4\" SizeC=\"1\" SizeT=\"1\" DimensionOrder=\"XYZCT\"", data)));
  EXPECT_EQ(first_samples(path), std::string("abc\0", 4));
  expect_text(remarks_of(path), "1 of 4 planes are missing and read as 0");
  write_tiff(path, flat_pages("a", ome("SizeZ=\"2147483647\" SizeC=\"99\" DimensionOrder=\"XYZCT\"", data)));
  expect_text(outcome(describe(path)), "planes, found 1");
  write_tiff(path, flat_pages("a", ome("SizeZ=\"2\" DimensionOrder=\"XYZCT\"", "<TiffData FirstZ=\"2\"/>")));
  expect_text(outcome(describe(path)), "FirstZ, FirstC or FirstT lies beyond");
}

TEST(TiffOme, WhatIsNotUsableIsRemarked) {
  const std::string path = temporary_path("remarks.ome.tif");
  const std::string sizes = "SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\" DimensionOrder=\"XYZCT\" ";
  for (const std::string size : {"0", "-1", "nan", "wide"}) {
    write_tiff(
        path,
        flat_pages(
            "ab", ome(sizes + "PhysicalSizeX=\"" + size + "\" PhysicalSizeY=\"2\" PhysicalSizeZ=\"3\"", "")));
    EXPECT_EQ(spacing_of(describe(path).value()), Vec3d(1, 2, 3));
    expect_text(remarks_of(path), "OME-XML: PhysicalSizeX: expected a number above 0, found '" + size +
                                      "'; a spacing of 1 is assumed");
  }
  write_tiff(path, flat_pages("ab", ome(sizes, "<TiffData/>")));
  EXPECT_EQ(remarks_of(path), "");
  write_tiff(path, flat_pages("abc", ome(sizes, "")));
  expect_text(remarks_of(path), "OME-XML does not say which planes page 3 is; it is not read");
  write_tiff(path, flat_pages("abcd", ome(sizes, "<TiffData IFD=\"0\"/><TiffData FirstZ=\"1\" IFD=\"3\"/>")));
  EXPECT_EQ(first_samples(path), "ad");
  expect_text(remarks_of(path), "page 2 and 1 other are; they are not read");
}

TEST(TiffOme, VolumesOverSeveralFiles) {
  const std::string folder = temporary_path("ome_files");
  std::filesystem::create_directories(folder);
  std::string data;
  for (const char* z : {"0", "1", "2"}) {
    data += std::string("<TiffData FirstZ=\"") + z + "\" IFD=\"0\"><UUID FileName=\"z" + z +
            ".ome.tif\">urn:uuid:" + z + "</UUID></TiffData>";
  }
  const std::string pixels = "SizeZ=\"3\" SizeC=\"1\" SizeT=\"1\" DimensionOrder=\"XYZCT\"";
  for (int z = 0; z < 3; ++z) {
    write_tiff(folder + "/z" + std::to_string(z) + ".ome.tif",
               flat_pages(std::string(1, static_cast<char>('a' + z)),
                          ome(pixels, data, "UUID=\"urn:uuid:" + std::to_string(z) + "\"")));
  }
  EXPECT_EQ(first_samples(folder + "/z1.ome.tif"), "abc");
  EXPECT_EQ(first_samples(folder), "abc");
  EXPECT_EQ(volume_files(folder + "/z1.ome.tif", {}).size(), 4u);
  std::filesystem::remove(folder + "/z0.ome.tif");
  EXPECT_EQ(first_samples(folder + "/z1.ome.tif"), std::string("\0bc", 3));
  expect_text(remarks_of(folder + "/z1.ome.tif"), "these files are not there: z0.ome.tif");

  // Metadata in a file of their own.
  write_file(folder + "/all.companion.ome", ome(pixels, data));
  const std::string only = "<OME><BinaryOnly MetadataFile=\"all.companion.ome\" UUID=\"u\"/></OME>";
  write_tiff(folder + "/z0.ome.tif", flat_pages("a", only));
  EXPECT_EQ(first_samples(folder + "/z0.ome.tif"), "abc");
  std::filesystem::remove(folder + "/all.companion.ome");
  EXPECT_EQ(first_samples(folder + "/z0.ome.tif"), "a");
  expect_text(remarks_of(folder + "/z0.ome.tif"), "all.companion.ome, which is not there");
}

TEST(TiffOme, SpacingUnitsNamesAndColours) {
  const std::string path = temporary_path("names.ome.tif");
  const std::string order = "SizeZ=\"1\" SizeC=\"2\" SizeT=\"1\" DimensionOrder=\"XYZCT\" ";
  const std::string channels =
      "<Channel ID=\"Channel:0:0\" Name=\"DAPI\" Color=\"65535\"/><Channel ID=\"Channel:0:1\" "
      "Color=\"-16776961\"/>";
  write_tiff(path, flat_pages("ab", ome(order + "PhysicalSizeX=\"500\" PhysicalSizeXUnit=\"nm\" "
                                                "PhysicalSizeY=\"0.75\" PhysicalSizeZ=\"2\"",
                                        channels)));
  VolumeDescription d = describe(path).value();
  EXPECT_NEAR(length(spacing_of(d) - Vec3d(0.5, 0.75, 2)), 0, 1e-12);
  EXPECT_EQ(d.unit, "\xC2\xB5m");
  ASSERT_EQ(d.channels.size(), 2u);
  EXPECT_EQ(d.channels[0].name, "DAPI");
  EXPECT_EQ(d.channels[0].color, Vec3f(0, 0, 1));
  EXPECT_EQ(d.channels[1].color, Vec3f(1, 0, 0));
  // One unit for all axes is kept.
  write_tiff(path, flat_pages("ab", ome(order + "PhysicalSizeX=\"5\" PhysicalSizeXUnit=\"mm\"", "")));
  d = describe(path).value();
  EXPECT_EQ(spacing_of(d), Vec3d(5, 1, 1));
  EXPECT_EQ(d.unit, "mm");
}

TEST(TiffOme, SeveralImagesAreSeries) {
  const std::string path = temporary_path("series.ome.tif");
  const std::string pixels =
      "<Pixels SizeX=\"4\" SizeY=\"3\" SizeZ=\"1\" SizeC=\"1\" SizeT=\"1\" "
      "DimensionOrder=\"XYZCT\"><TiffData IFD=\"";
  write_tiff(path, flat_pages("ab", "<OME><Image Name=\"one\">" + pixels + "0\"/></Pixels></Image><Image>" +
                                        pixels + "1\"/></Pixels></Image></OME>"));
  EXPECT_EQ(first_samples(path), "a");
  expect_text(remarks_of(path), "has 2 images: 1 ('one', 4 x 3 x 1), 2 (4 x 3 x 1); the first is read");
  VolumeOptions options;
  options.series = "2";
  EXPECT_EQ(first_samples(path, options), "b");
  options.series = "3";
  expect_text(outcome(describe(path, options)), "series: expected a number from 1 to 2");
}

TEST(TiffOme, HostileXmlIsAnErrorOfOneLine) {
  const auto error_of = [](const std::string& xml) { return outcome(parse_ome_xml("x.tif", xml)); };
  const std::string bomb =
      "<!DOCTYPE OME [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]><OME UUID=\"&b;\"/>";
  EXPECT_TRUE(is_ome_xml(bomb));
  expect_text(error_of(bomb), "a document type is not expected");
  expect_text(error_of("<OME><Image></OME>"), "x.tif: OME-XML, line 1: ");
  expect_text(error_of("<XML/>"), "expected the element OME");
  expect_text(error_of(""), "OME-XML");
  std::string deep = "<OME>";
  for (int i = 0; i < 200; ++i) deep += "<a>";
  expect_text(error_of(deep), "nested too deeply");
  expect_text(error_of("<OME><Image><Pixels SizeZ=\"-1\"/></Image></OME>"),
              "SizeZ: expected a whole number from 1, found '-1'");
  expect_text(error_of("<OME><Image><Pixels SizeZ=\"99999999999\"/></Image></OME>"),
              "SizeZ: expected at most");
  EXPECT_FALSE(is_ome_xml("ImageJ=1") || is_ome_xml("<svg/>") || is_ome_xml("<!-- OME") || is_ome_xml(""));
  EXPECT_TRUE(is_ome_xml("\xEF\xBB\xBF<ome:OME xmlns:ome=\"u\"/>"));
}

}  // namespace
}  // namespace gvx::io::test
