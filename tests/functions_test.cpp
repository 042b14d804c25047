// What values and labels look like without a file of points: --window, --percentile, --opacity, --labels.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/io/image.h"
#include "program_support.h"

namespace gvx {
namespace {

class Functions : public ProgramTest {
 protected:
  Functions() : ProgramTest("gvx_functions") {}

  void put(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  std::string bytes(const std::string& name) const {
    std::ifstream file(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// Renders and returns the picture's bytes.
  std::string picture(const std::string& scene, const std::string& flags) const {
    const Outcome outcome = gvx("render " + scene + " -o p.png --size 40x40 --quiet " + flags);
    EXPECT_EQ(outcome.status, 0) << flags << "\n" << outcome.output;
    EXPECT_EQ(outcome.output, "") << flags;
    return bytes("p.png");
  }
  /// 24 x 24 x 24 labels: 7 in the left half of a box, 300 in the right half.
  std::string write_labels() const {
    std::string samples;
    for (int z = 0; z < 24; ++z) {
      for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 24; ++x) {
          const bool inside = std::min({x, y, z}) >= 4 && std::max({x, y, z}) < 20;
          const int label = !inside ? 0 : x < 12 ? 7 : 300;
          samples += {static_cast<char>(label & 255), static_cast<char>(label >> 8)};
        }
      }
    }
    const std::string name = "labels_24x24x24_uint16.raw";
    put(name, samples);
    return name;
  }
};

TEST_F(Functions, a_window_shows_what_lies_in_it) {
  const std::string ball = write_ball();
  const std::string bright = picture(ball, "--window 230,10"), all = picture(ball, "--window 100,200");
  EXPECT_NE(bright, all);
  // The ball has values from 0 to 236.
  EXPECT_EQ(picture(ball, "--tf gray --percentile 0,100"), picture(ball, "--tf gray --window 118,236"));
  EXPECT_NE(picture(ball, "--percentile 50,100"), picture(ball, "--percentile 99,100"));
  const Outcome outcome = gvx("render " + ball + " -o p.png --size 20x20 --window 5000,10");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_NE(outcome.output.find("nothing can be seen"), std::string::npos) << outcome.output;
}

TEST_F(Functions, opacity_is_a_factor) {
  const std::string ball = write_ball();
  EXPECT_EQ(picture(ball, "--tf solid --opacity 1"), picture(ball, "--tf solid"));
  EXPECT_NE(picture(ball, "--tf solid --opacity 0.1"), picture(ball, "--tf solid"));
}

TEST_F(Functions, channels_have_a_window_each_and_the_last_repeats) {
  const std::string ball = write_ball();
  ASSERT_EQ(gvx("build " + ball + " " + ball + " -o two.gvx").status, 0);
  const std::string both = picture("two.gvx", "--window 200,50 --window 100,50");
  EXPECT_NE(both, picture("two.gvx", "--window 200,50"));
  EXPECT_EQ(picture("two.gvx", "--window 200,50 --window 200,50"), picture("two.gvx", "--window 200,50"));
  expect_error("render two.gvx -o p.png --window 1,1 --window 2,2 --window 3,3",
               "--window: 3 transfer functions for a volume that takes 2");
}

TEST_F(Functions, saved_scenes_give_the_same_picture) {
  const std::string ball = write_ball();
  for (const std::string flags : {"--window 120,60 --opacity 0.5", "--percentile 20,99.5",
                                  "--tf solid --opacity 0.3", "--mode maximum --window 200,100"}) {
    const std::string first = picture(ball, flags + " --save-scene s.json");
    EXPECT_EQ(picture("s.json", ""), first) << flags << bytes("s.json");
  }
  put("w.json", R"({"volume": ")" + ball + R"(", "function": {"percentile": [20, 99.5]}})");
  EXPECT_EQ(picture("w.json", ""), picture(ball, "--percentile 20,99.5"));
  EXPECT_EQ(picture("w.json", "--window 120,60"), picture(ball, "--window 120,60"));
}

TEST_F(Functions, bad_values_name_the_flag_before_anything_is_read) {
  for (const auto& [flags, part] : std::vector<std::pair<std::string, std::string>>{
           {"--window 40", "--window: '40' is not LEVEL,WIDTH"},
           {"--window 40,0", "--window: '40,0' is not LEVEL,WIDTH"},
           {"--window 40,x", "--window: '40,x' is not LEVEL,WIDTH"},
           {"--window nan,1", "--window: 'nan,1' is not"},
           {"--percentile 5", "--percentile: '5' is not LOW,HIGH"},
           {"--percentile 99,5", "--percentile: '99,5' is not LOW,HIGH"},
           {"--percentile 5,101", "--percentile: '5,101' is not LOW,HIGH"},
           {"--opacity -1", "--opacity: -1 is not a factor from 0 to 1000"},
           {"--window 1,1 --percentile 1,2", "--percentile: does not go with --window"},
           {"--labels missing.txt", "--labels missing.txt: cannot open"}}) {
    expect_error("render nowhere.nii -o p.png " + flags, part);
  }
  expect_error("render sponge -o p.png --percentile 1,99", "--percentile: the volume has no histogram");
}

TEST_F(Functions, labels_have_the_colors_of_a_table) {
  const std::string labels = write_labels();
  put("t.tsv", "index\tname\tcolor\n7\tleft\t#ff0000\n300\tright\t#0000ff\n");
  const std::string flat = "--flat --background 0,0,0 --camera 'eye=12,-60,12;target=12,12,12;up=0,0,1' ";
  picture(labels, "--labels t.tsv --save-scene s.json " + flat);
  const auto image = io::read_png(path("p.png"));
  ASSERT_TRUE(image.ok()) << image.error().message;
  const auto pixel = [&](std::size_t x, std::size_t y) {
    return image.value().rgba.data() + 4 * (y * 40 + x);
  };
  EXPECT_GT(pixel(17, 20)[0], 240);
  EXPECT_LT(pixel(17, 20)[2], 20);
  EXPECT_GT(pixel(22, 20)[2], 240);
  EXPECT_LT(pixel(22, 20)[0], 20);
  EXPECT_EQ(pixel(1, 1)[0], 0);
  const std::string first = bytes("p.png");
  EXPECT_EQ(picture("s.json", ""), first);
  // A store of labels takes the same table, and no flag where there is none.
  ASSERT_EQ(gvx("build " + labels + " -o l.gvx --labels").status, 0);
  EXPECT_EQ(picture("l.gvx", "--labels t.tsv " + flat), first);
  EXPECT_EQ(picture("l.gvx", flat), picture(labels, "--labels " + flat));
  EXPECT_NE(picture("l.gvx", flat), first);
  picture("l.gvx", "--labels t.tsv --stats l.json " + flat);
  EXPECT_EQ(read_json("l.json")["labels"],
            nlohmann::json::parse(R"([{"label": 7, "name": "left", "color": "#ff0000"},
                                      {"label": 300, "name": "right", "color": "#0000ff"}])"));
  put("other.txt", "4000 elsewhere 1 2 3 0\n");
  const Outcome other = gvx("render l.gvx -o p.png --quiet --size 9x9 --labels other.txt");
  EXPECT_EQ(other.status, 0);
  EXPECT_NE(other.output.find("--labels other.txt: the volume has none of these labels"), std::string::npos)
      << other.output;
  // The table may hide one of them.
  put("h.txt", "7 left 255 0 0 255\n300 right 0 0 255 0\n");
  EXPECT_NE(picture("l.gvx", "--labels h.txt " + flat), first);
}

TEST_F(Functions, labels_may_stand_before_the_scene) {
  const std::string labels = write_labels();
  const std::string behind = picture(labels, "--labels");
  const Outcome before = gvx("render --labels " + labels + " -o b.png --size 40x40 --quiet");
  EXPECT_EQ(before.status, 0) << before.output;
  EXPECT_EQ(bytes("b.png"), behind);
  EXPECT_NE(picture(labels, ""), behind);
  expect_error("render --labels -o b.png", "SCENE", 2);
  expect_error("render -o b.png", "SCENE", 2);
}

TEST_F(Functions, labels_and_values_are_not_mixed_up) {
  const std::string labels = write_labels();
  put("t.tsv", "index\tname\tcolor\n7\tleft\t#ff0000\n");
  ASSERT_EQ(gvx("build " + labels + " -o values.gvx").status, 0);
  expect_error("render values.gvx -o p.png --labels", "--labels: the volume's numbers are no labels");
  expect_error("render " + labels + " -o p.png --labels --window 1,1",
               "--window: the volume's numbers are labels");
  expect_error("render " + labels + " -o p.png --labels t.tsv --tf gray",
               "--labels t.tsv: does not go with a transfer function (--tf)");
  put("bad.tsv", "index\tcolor\n7\tred\n");
  expect_error("render " + labels + " -o p.png --labels bad.tsv",
               "--labels bad.tsv: line 2: expected a colour as #rrggbb, found");
}

TEST_F(Functions, a_nifti_file_of_labels_needs_no_flag) {
  std::string header(352, '\0');
  const auto set16 = [&](std::size_t at, int value) {
    header[at] = static_cast<char>(value & 255);
    header[at + 1] = static_cast<char>(value >> 8);
  };
  set16(0, 348);
  set16(40, 3);
  for (const std::size_t at : {42, 44, 46}) set16(at, 24);
  set16(68, 1002);
  set16(70, 512);
  set16(72, 16);
  header.replace(108, 4, std::string("\0\0\xb0\x43", 4));
  header.replace(344, 4, std::string("n+1\0", 4));
  put("seg.nii", header + bytes(write_labels()));
  const std::string plain = picture("seg.nii", "");
  EXPECT_EQ(picture("seg.nii", "--labels"), plain);
  EXPECT_NE(picture("seg.nii", "--no-labels"), plain);
  ASSERT_EQ(gvx("build seg.nii -o seg.gvx").status, 0);
  EXPECT_EQ(picture("seg.gvx", ""), plain);
  ASSERT_EQ(gvx("build seg.nii -o values.gvx --no-labels").status, 0);
  EXPECT_EQ(picture("values.gvx", ""), picture("seg.nii", "--no-labels"));
}

}  // namespace
}  // namespace gvx
