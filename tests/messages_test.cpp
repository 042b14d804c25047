// What the program says of mistakes: one line that names the flag or the file, what is wrong and what to do.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "program_support.h"

namespace gvx {
namespace {

namespace fs = std::filesystem;

class Messages : public ProgramTest {
 protected:
  Messages() : ProgramTest("gvx_messages") {}

  void write(const std::string& name, const std::string& bytes) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    std::ofstream(path(name), std::ios::binary) << bytes;
  }
  /// The whole line of error, and its status.
  void expect_line(const std::string& arguments, const std::string& line, int status = 2) const {
    const Outcome outcome = gvx(arguments);
    EXPECT_EQ(outcome.status, status) << arguments;
    EXPECT_EQ(outcome.output, "gvx: " + line + "\n") << arguments;
  }
};

TEST_F(Messages, mistyped_words_are_told_from_those_that_are_there) {
  expect_line("rendr ball.gvx -o a.png",
              "'rendr' is not a command (info, build, render or verify); did you mean render?");
  expect_line("", "expected a command: info, build, render or verify (gvx --help)");
  expect_line("frobnicate", "'frobnicate' is not a command (info, build, render or verify) (gvx --help)");
  expect_line("render sponge -o a.png --isovalu 5",
              "--isovalu: gvx render has no such flag; did you mean --isovalue?");
  expect_line("render sponge -o a.png --iso=5",
              "--iso: gvx render has no such flag; did you mean --isovalue?");
  expect_line("render sponge -o a.png -size 5x5", "-size: gvx render has no such flag; did you mean --size?");
  expect_line("render sponge -o a.png --frobnicate",
              "--frobnicate: gvx render has no such flag (gvx render --help)");
  expect_line(
      "render sponge -o a.png --mode maximim",
      "--mode: 'maximim' is not composite, maximum, minimum, mean or isosurface; did you mean maximum?");
  expect_line("build a.raw -o a.gvx --codec zst",
              "--codec: 'zst' is not zstd, lz4 or none; did you mean zstd?");
  expect_line("build a.raw -o a.gvx --brick 12", "--brick: '12' is not 8, 16 or 32");
}

TEST_F(Messages, mistyped_names_of_scenes_and_presets_are_told_from_those_that_are_there) {
  expect_error("render spong -o a.png", "spong: neither a file nor a made scene; did you mean sponge?");
  expect_error("render sponge -o a.png --tf ct-bome", "did you mean ct-bone?");
  expect_error("render sponge -o a.png --memory 5", "--memory: 5 bytes");
}

TEST_F(Messages, a_bad_value_is_told_with_its_flag_and_what_was_expected) {
  expect_line("render sponge -o a.png --isovalue bone", "--isovalue: 'bone' is not a number");
  expect_line("render sponge -o a.png --antialias 1.5",
              "--antialias: '1.5' is not a whole number, 0 or more");
  expect_line("render sponge -o a.png --threads -1", "--threads: '-1' is not a whole number from 0 to 1024");
  expect_line("build a.raw -o a.gvx --resolution 0",
              "--resolution: '0' is not a whole number from 1 to 1048576");
  expect_line("render sponge -o a.png --antialias 9",
              "--antialias: expected a whole number from 1 to 8, found 9", 1);
  expect_line("render sponge -o a.png --ambient -1", "--ambient: expected a number from 0 to 100, found -1.0",
              1);
  expect_line("render sponge -o a.png --size 0x7", "--size: '0x7' is not a size such as 1280x720", 1);
  expect_line("render sponge -o a.png --size 1x99999",
              "--size: height: expected a whole number from 1 to 32768, found 99999", 1);
  expect_line("render sponge -o a.png --background red",
              "--background: 'red' is not red,green,blue: three numbers such as 0.2,0.3,0.4", 1);
}

TEST_F(Messages, what_is_missing_or_too_much_is_told) {
  expect_line("render sponge", "-o is missing: gvx render SCENE -o OUTPUT (gvx render --help)");
  expect_line("render -o a.png", "SCENE is missing: gvx render SCENE -o OUTPUT (gvx render --help)");
  expect_line("info", "PATH is missing: gvx info PATH (gvx info --help)");
  expect_line("render sponge -o", "-o: expected a value, found the end of the line (gvx render --help)");
  expect_line("render sponge -o --size 8x8", "-o: expected a value, found the flag --size");
  expect_line("render sponge cloud -o a.png",
              "more than was expected: 'cloud'; gvx render SCENE -o OUTPUT (gvx render --help)");
  expect_line("render sponge -o a.png --size 8x8 --size 9x9", "--size: expected once, found 2 times");
  expect_line("render sponge -o a.png --exact --budget 5ms", "--exact: does not go with --budget");
  expect_line("verify a.gvx b.gvx", "more than was expected: 'b.gvx'; gvx verify STORE (gvx verify --help)");
  expect_line("render sponge -o a.png --zoom 5", "--zoom: only with --frames");
}

TEST_F(Messages, files_that_are_not_read_say_what_to_do) {
  write("scan.vti", "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"0.1\">\n");
  write("nameless", "\x89PNG\r\n\x1a\n and more");
  write("series/0001.png", "\x89PNG\r\n\x1a\n");
  write("series/0002.png", "\x89PNG\r\n\x1a\n");
  write("image.zarr/.zgroup", "{}");
  write("empty.nrrd", "");
  const struct {
    const char* name;
    const char* line;
  } cases[] = {
      {"scan.vti",
       "scan.vti: VTK image data is not read yet; convert it to NRRD, NIfTI or MetaImage, for example "
       "with ParaView or 3D Slicer"},
      {"nameless",
       "nameless: A PNG picture is one slice, not a volume; open the whole stack as an image sequence and "
       "save it as one NRRD file, for example with Fiji"},
      {"series",
       "series: a folder of 2 PNG pictures is not read yet; open the whole stack as an image sequence and "
       "save it as one NRRD file, for example with Fiji"},
      {"image.zarr",
       "image.zarr: a Zarr folder is not read yet; write one level of it as NRRD, for example with Python "
       "(zarr and pynrrd) or Fiji"},
      {"empty.nrrd", "empty.nrrd: the file is empty; expected a volume or a mesh"}};
  for (const auto& [name, line] : cases) {
    expect_line(std::string("info ") + name, line, 1);
    expect_line(std::string("build ") + name + " -o a.gvx", line, 1);
    expect_line(std::string("render ") + name + " -o a.png", line, 1);
  }
}

TEST_F(Messages, info_shows_ranges_percentiles_and_a_histogram) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  const auto of_file =
      nlohmann::json::parse(gvx("info ball_40x36x30_uint8.raw --json").output).at("channels").at(0);
  const auto of_store = nlohmann::json::parse(gvx("info ball.gvx --json").output).at("channels").at(0);
  EXPECT_EQ(of_file, of_store);
  EXPECT_EQ(of_file["numbers"], 40 * 36 * 30);
  EXPECT_EQ(of_file["minimum"], 0);
  EXPECT_GT(of_file["maximum"], 230);
  EXPECT_EQ(of_file["percentiles"]["1"], 0);
  EXPECT_GT(of_file["percentiles"]["99.9"], of_file["percentiles"]["50"]);
  EXPECT_EQ(of_file["distinct"].front(), 0);
  const std::string text = gvx("info ball.gvx").output;
  for (const char* part : {"values", "percentiles  0.1 %: 0, 1 %: 0, 50 %: ", "histogram", "|#"}) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
  EXPECT_NE(gvx("info ball_40x36x30_uint8.raw").output.find("percentiles"), std::string::npos);
  const std::string header = gvx("info ball_40x36x30_uint8.raw --header").output;
  EXPECT_EQ(header.find("percentiles"), std::string::npos) << header;
  EXPECT_NE(header.find("not read"), std::string::npos) << header;
}

TEST_F(Messages, info_reads_no_more_than_it_is_asked_for) {
  // A file of 2 GiB that takes no room on the disk.
  std::ofstream(path("large_2048x1024x1024_uint8.raw")).close();
  fs::resize_file(path("large_2048x1024x1024_uint8.raw"), std::uint64_t{1} << 31);
  const std::string text = gvx("info large_2048x1024x1024_uint8.raw").output;
  EXPECT_NE(text.find("not read (--values reads them, 2.0 GiB)"), std::string::npos) << text;
}

/// A page of 2 x 2 bytes of a little-endian TIFF file, at this place in it, with its directory and text
/// behind it.
std::string tiff_page(std::uint32_t at, char first, const std::string& description, bool last) {
  const auto number = [](std::uint64_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> 8 * i);
    return text;
  };
  constexpr std::uint32_t kPixels = 4, kFields = 9, kDirectory = 2 + 12 * kFields + 4;
  const std::uint32_t text = at + kPixels + kDirectory,
                      end = text + static_cast<std::uint32_t>(description.size());
  std::string page;
  for (int i = 0; i < 4; ++i) page += static_cast<char>(first + i);
  page += number(kFields, 2);
  const auto field = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t count, std::uint32_t value) {
    page += number(tag, 2) + number(type, 2) + number(count, 4) + number(value, 4);
  };
  constexpr std::uint32_t kText = 2, kShort = 3, kLong = 4;
  field(256, kLong, 1, 2);  // width, height, bits, compression, photometric
  field(257, kLong, 1, 2);
  field(258, kShort, 1, 8);
  field(259, kShort, 1, 1);
  field(262, kShort, 1, 1);
  field(270, kText, static_cast<std::uint32_t>(description.size()), text);
  field(273, kLong, 1, at);  // strip, rows in it, bytes of it
  field(278, kLong, 1, 2);
  field(279, kLong, 1, kPixels);
  return page + number(last ? 0 : end + kPixels, 4) + description;
}

TEST_F(Messages, info_tells_a_channels_name_with_its_values) {
  const std::string about =
      R"(<?xml version="1.0"?><OME xmlns="http://www.openmicroscopy.org/Schemas/OME/2016-06"><Image ID="Image:0">)"
      R"(<Pixels ID="Pixels:0" DimensionOrder="XYZCT" Type="uint8" SizeX="2" SizeY="2" SizeZ="1" SizeC="2" SizeT="1">)"
      R"(<Channel ID="Channel:0:0" Name="DAPI"/><Channel ID="Channel:0:1" Name="GFP"/><TiffData/>)"
      R"(</Pixels></Image></OME>)" +
      std::string(1, '\0');
  const std::string first = tiff_page(8, 10, about, false);
  const auto second_at = static_cast<std::uint32_t>(8 + first.size());
  std::string bytes = std::string("II*\0", 4) + std::string("\x0c\0\0\0", 4) + first;
  write("two.tif", bytes + tiff_page(second_at, 20, about, true));
  const Outcome told = gvx("info two.tif --json > two.json");
  if (told.output.find("built without libtiff") != std::string::npos) GTEST_SKIP() << told.output;
  ASSERT_EQ(told.status, 0) << told.output;
  const auto channels = read_json("two.json")["channels"];
  ASSERT_EQ(channels.size(), 2u) << channels;
  EXPECT_EQ(channels[0]["name"], "DAPI");
  EXPECT_EQ(channels[0]["maximum"], 13);
  EXPECT_EQ(channels[1]["name"], "GFP");
  EXPECT_EQ(channels[1]["maximum"], 23);
}

}  // namespace
}  // namespace gvx
