// What gvx render shows where the command line says little of the camera.

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gvx/io/image.h"
#include "program_support.h"

namespace gvx {
namespace {

class Cameras : public ProgramTest {
 protected:
  Cameras() : ProgramTest("gvx_cameras") {}

  void put(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

  /// A closed box of this size, a corner of which is at `corner`.
  void put_box(const std::string& name, std::array<double, 3> size, std::array<double, 3> corner = {}) const {
    std::ofstream file(path(name));
    file.precision(17);
    for (int i = 0; i < 8; ++i) {
      file << "v " << corner[0] + (i & 1) * size[0] << ' ' << corner[1] + (i >> 1 & 1) * size[1] << ' '
           << corner[2] + (i >> 2 & 1) * size[2] << '\n';
    }
    file << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  }

  /// "0,1,0" of the camera that is printed for these arguments.
  std::vector<double> printed(const std::string& arguments, const std::string& part) const {
    const Outcome outcome = gvx("render " + arguments + " -o printed.png");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    const std::size_t camera = outcome.output.find("--camera '");
    const std::size_t at = outcome.output.find(part + "=", camera);
    EXPECT_NE(at, std::string::npos) << outcome.output;
    if (at == std::string::npos) return {};
    std::vector<double> numbers;
    const char* text = outcome.output.c_str() + at + part.size();
    do {
      char* end = nullptr;
      numbers.push_back(std::strtod(text + 1, &end));
      text = end;
    } while (*text == ',');
    return numbers;
  }

  /// Columns and rows of a picture of 200 x 200 in which anything is seen.
  struct Seen {
    int columns = 0, rows = 0;
  };
  Seen seen(const std::string& arguments) const {
    const Outcome outcome = gvx("render " + arguments + " -o seen.png --size 200x200 --transparent --quiet");
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    const auto image = io::read_png(path("seen.png")).value();
    std::vector<bool> column(200), row(200);
    for (std::size_t y = 0; y < 200; ++y) {
      for (std::size_t x = 0; x < 200; ++x) {
        if (image.rgba[4 * (200 * y + x) + 3] < 128) continue;
        column[x] = row[y] = true;
      }
    }
    return {static_cast<int>(std::count(column.begin(), column.end(), true)),
            static_cast<int>(std::count(row.begin(), row.end(), true))};
  }

  bool can_make_voxels() const {
    put_box("probe.obj", {1, 1, 1});
    return gvx("build probe.obj -o probe.gvx --resolution 8").status == 0;
  }
};

TEST_F(Cameras, a_view_is_from_a_side_of_what_stands_upright) {
  const std::string render = "sponge --size 20x20 ";
  const auto eye = [&](const std::string& flags) { return printed(render + flags, "eye"); };
  EXPECT_LT(eye("--view front")[1], -1);
  EXPECT_GT(eye("--view back")[1], 2);
  EXPECT_LT(eye("--view left")[0], -1);
  EXPECT_GT(eye("--view right")[0], 2);
  EXPECT_GT(eye("--view top")[2], 2);
  EXPECT_LT(eye("--view bottom")[2], -1);
  EXPECT_GT(eye("--view front --up y")[2], 2);
  EXPECT_GT(eye("--view top --up y")[1], 2);
  EXPECT_EQ(printed(render + "--up y", "up"), (std::vector<double>{0, 1, 0}));
  EXPECT_EQ(printed(render + "--view front --camera 'fov=7;up=1,0,0'", "up"), (std::vector<double>{1, 0, 0}));
  EXPECT_EQ(printed(render + "--view front --camera 'fov=7'", "fov"), (std::vector<double>{7}));

  put("side.json", R"({"volume": "sponge", "size": [20, 20], "camera": {"view": "left", "height": "fit"}})");
  EXPECT_LT(printed("side.json", "eye")[0], -0.1);
  EXPECT_NEAR(printed("side.json", "height")[0], 1.25, 1e-9);
  EXPECT_GT(printed("side.json --view right", "eye")[0], 1.1);
  EXPECT_EQ(printed("side.json --camera 'eye=3,4,5'", "eye"), (std::vector<double>{3, 4, 5}));
  put("up.json", R"({"volume": "sponge", "upAxis": "y", "size": [20, 20]})");
  EXPECT_EQ(printed("up.json --save-scene saved.json", "up"), (std::vector<double>{0, 1, 0}));
  EXPECT_EQ(read_json("saved.json")["upAxis"], "y");
  EXPECT_EQ(printed("saved.json", "eye"), printed("up.json", "eye"));
}

TEST_F(Cameras, contradictions_are_errors) {
  expect_error("render sponge -o a.png --view front --camera eye=1,2,3", "--view front: ");
  expect_error("render sponge -o a.png --view front --camera up=0,1,0", "up points along the view");
  expect_error("render sponge -o a.png --camera up=0,0,0", "up: expected a direction");
  expect_error("render sponge -o a.png --key-frame 1:height=fit", "height must be a number");
  expect_error("render sponge -o a.png --view sideways", "sideways", 2);
  expect_error("render sponge -o a.png --up x", "--up", 2);
  put("a.json", R"({"volume": "sponge", "camera": {"view": "left", "eye": [1, 2, 3]}})");
  expect_error("render a.json -o a.png", "camera: expected view or eye, found both");
  put("b.json", R"({"volume": "sponge", "camera": {"fov": 20, "height": "fit"}})");
  expect_error("render b.json -o a.png", "camera: expected fov or height, found both");
  put("c.json", R"({"volume": "sponge", "cameraPath": [{"frame": 1, "height": "fit"}]})");
  expect_error("render c.json -o a.png", "cameraPath[0].height");
  put("d.json", R"({"volume": "sponge", "camera": {"view": "sideways"}})");
  expect_error("render d.json -o a.png", "camera.view: expected one of front, back");
  write_ball();
  expect_error("build ball_40x36x30_uint8.raw -o b.gvx --up y", "--up are for meshes");
}

TEST_F(Cameras, a_part_alone_leaves_the_rest_to_frame_the_scene) {
  write_ball();
  const std::string ball = "ball_40x36x30_uint8.raw --size 20x20 ";
  const auto distance = [&](const std::string& flags) {
    const auto eye = printed(ball + flags, "eye"), target = printed(ball + flags, "target");
    return std::hypot(std::hypot(eye[0] - target[0], eye[1] - target[1]), eye[2] - target[2]);
  };
  EXPECT_GT(distance("--camera fov=10"), 2.5 * distance(""));
  const auto centre = printed(ball + "--camera eye=9,9,99", "target");
  EXPECT_NEAR(centre[0], 20, 0.6);
  EXPECT_NEAR(centre[1], 18, 0.6);
  EXPECT_NEAR(centre[2], 15, 0.6);
  const auto above = printed(ball + "--camera up=0,1,0", "eye");
  EXPECT_GT(above[1], 30);
  EXPECT_GT(above[2], 60);  // in front of what has y up
  EXPECT_EQ(printed(ball + "--camera target=1,2,3", "target"), (std::vector<double>{1, 2, 3}));
  // What is cut off is not framed.
  EXPECT_LT(distance("--clip 0,0,0,0.5,0.5,0.5"), 0.7 * distance(""));
}

TEST_F(Cameras, a_mesh_stands_upright_and_fills_the_picture) {
  if (!can_make_voxels()) GTEST_SKIP() << "needs Embree";
  put_box("tall.obj", {1, 3, 1});
  const auto info = nlohmann::json::parse(gvx("info tall.obj --json").output);
  EXPECT_EQ(info["up"], "y");
  EXPECT_EQ(info["up_guessed"], true);
  EXPECT_EQ(info["maximum"], (std::vector<double>{1, 3, 1}));
  EXPECT_NE(gvx("info tall.obj").output.find("y, as in most OBJ files"), std::string::npos);
  const std::string said = "y is up, as in most OBJ files (--up overrides it)";
  const Outcome built = gvx("build tall.obj -o tall.gvx --resolution 200");
  EXPECT_NE(built.output.find(said), std::string::npos) << built.output;
  EXPECT_EQ(nlohmann::json::parse(gvx("info tall.gvx --json").output)["up"], "y");
  const Outcome rendered = gvx("render tall.obj -o a.png --size 9x9 --resolution 200");
  EXPECT_NE(rendered.output.find(said), std::string::npos) << rendered.output;
  EXPECT_EQ(gvx("render tall.obj -o a.png --size 9x9 --resolution 200 --quiet").output, "");

  for (const char* scene : {"tall.gvx ", "tall.obj --resolution 200 "}) {
    for (const std::string flat : {"", "--camera height=fit "}) {
      // The mesh itself, not the empty voxels around it; its front alone is seen, nearly.
      const Seen front = seen(scene + flat + "--view front");
      EXPECT_NEAR(front.rows, 160, 6) << scene << flat;
      EXPECT_NEAR(front.columns, 160 / 3, 6) << scene << flat;
      EXPECT_NEAR(seen(scene + flat + "--view top").rows, 160, 6) << scene << flat;
      EXPECT_NEAR(seen(scene + flat).rows, 160, 6) << scene << flat;
    }
    // Of one that lies, the end is in front.
    const Seen lying = seen(std::string(scene) + "--up z --view front --camera height=fit");
    EXPECT_NEAR(lying.rows, 160, 6) << scene;
    EXPECT_NEAR(lying.columns, 160, 6) << scene;
  }
  ASSERT_EQ(gvx("build tall.obj -o lying.gvx --resolution 200 --up z").output.find("up"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(gvx("info lying.gvx --json").output)["up"], "z");
  EXPECT_NEAR(seen("lying.gvx --view front --camera height=fit").columns, 160, 6);

  put_box("house.obj", {10, 10, 10}, {500000, 5400000, 300});
  EXPECT_EQ(nlohmann::json::parse(gvx("info house.obj --json").output)["up"], "z");
}

TEST_F(Cameras, isosurfaces_are_ivory_before_a_background_that_projections_have_not) {
  write_ball();
  const auto picture = [&](const std::string& flags) {
    const Outcome outcome = gvx("render ball_40x36x30_uint8.raw -o p.png --size 40x40 --quiet " + flags);
    EXPECT_EQ(outcome.status, 0) << outcome.output;
    return io::read_png(path("p.png")).value();
  };
  for (const int isovalue : {20, 230}) {
    const auto image =
        picture("--mode isosurface --light camera:0,0,1 --isovalue " + std::to_string(isovalue));
    const std::size_t middle = 4 * (40 * 20 + 20);
    EXPECT_GT(image.rgba[middle], 180);
    EXPECT_GT(image.rgba[middle + 2], 140);
    EXPECT_LE(image.rgba[middle + 2], image.rgba[middle]);
    EXPECT_EQ(image.rgba[0], std::lround(0.13 * 255));
  }
  EXPECT_EQ(picture("--mode maximum").rgba[2], 0);
  EXPECT_EQ(picture("--mode maximum --background 1,0.5,0").rgba[0], 255);
  EXPECT_EQ(picture("--transparent").rgba[3], 0);
}

}  // namespace
}  // namespace gvx
