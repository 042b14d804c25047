// The program as a user runs it: what it prints, what it writes, and how it fails.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include "gvx/io/image.h"
#include "program_support.h"

namespace gvx {
namespace {

namespace fs = std::filesystem;

class Program : public ProgramTest {
 protected:
  Program() : ProgramTest("gvx_program") {}
};

TEST_F(Program, explains_itself) {
  for (const char* arguments :
       {"--help", "info --help", "build --help", "render --help", "verify --help", "--version"}) {
    const Outcome outcome = gvx(arguments);
    EXPECT_EQ(outcome.status, 0);
    EXPECT_NE(outcome.output.find("gvx"), std::string::npos);
  }
}

TEST_F(Program, help_says_in_words_what_a_flag_takes) {
  const std::string build = gvx("build --help").output, render = gvx("render --help").output;
  for (const char* text : {"Usage: gvx build [OPTIONS] INPUT..", "-o, --output TEXT (required)",
                           "--brick 8|16|32", "--components N (1 to 4)", "--labels, --no-labels"}) {
    EXPECT_NE(build.find(text), std::string::npos) << text;
  }
  EXPECT_NE(render.find("--budget TEXT (not with --exact, --frames)"), std::string::npos);
  EXPECT_NE(render.find("--zoom NUMBER (1e-30 to 1e+30) (only with --frames)"), std::string::npos);
  for (const char* text : {"REQUIRED", "Excludes", "Needs", "INT:", "{", "(1x)"}) {
    EXPECT_EQ(build.find(text), std::string::npos) << text;
    EXPECT_EQ(render.find(text), std::string::npos) << text;
  }
}

TEST_F(Program, info_subtracts_a_negative_offset) {
  write_ball("ball.raw");
  ASSERT_EQ(gvx("build ball.raw -o ball.gvx --dims 40,36,30 --dtype i8").status, 0);
  const std::string info = gvx("info ball.gvx").output;
  EXPECT_NE(info.find("1 * stored - 128\n"), std::string::npos) << info;
}

TEST_F(Program, builds_verifies_describes_and_renders) {
  write_ball();
  Outcome outcome = gvx("build ball_40x36x30_uint8.raw -o ball.gvx --brick 8 --codec lz4 --spacing 1,1,2");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(gvx("verify ball.gvx").status, 0);
  outcome = gvx("info ball.gvx --json");
  const auto info = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(info["dimensions"], (std::vector<int>{40, 36, 30}));
  EXPECT_EQ(info["spacing"], (std::vector<double>{1, 1, 2}));
  EXPECT_EQ(info["brick"], 8);
  EXPECT_EQ(info["codec"], "lz4");
  EXPECT_EQ(info["format"], "gvx store, version 3");
  EXPECT_EQ(info["border"], 2);
  ASSERT_EQ(info["sections"].size(), 3u);
  EXPECT_EQ(info["sections"][0]["name"], "directory");
  EXPECT_NE(gvx("info ball.gvx").output.find("directory"), std::string::npos);
  outcome = gvx("render ball.gvx -o ball.png --size 80x60 --tf solid --stats ball.json");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto image = io::read_png(path("ball.png")).value();
  EXPECT_EQ(image.width, 80u);
  EXPECT_GT(image.rgba[4 * (80 * 30 + 40)], 100);  // the ball is in the middle
  // And not in the corner, where the background is.
  EXPECT_EQ(image.rgba[0], std::lround(0.13 * 255));
  EXPECT_EQ(image.rgba[2], std::lround(0.2 * 255));
  const auto statistics = read_json("ball.json");
  for (const char* field : {"frame_milliseconds", "passes", "requests", "bricks_produced", "bricks_resident",
                            "nodes_resident", "bytes_read", "samples", "peak_memory_bytes", "converged",
                            "resident_share", "worst_lack", "level_bias", "stages"}) {
    EXPECT_TRUE(statistics.contains(field)) << field;
  }
  EXPECT_EQ(statistics["converged"], true);
  // The camera that it prints is one that it takes, and gives the same picture.
  const std::size_t at = outcome.output.find("--camera");
  ASSERT_NE(at, std::string::npos);
  const std::string camera = outcome.output.substr(at, outcome.output.find('\n', at) - at);
  ASSERT_EQ(gvx("render ball.gvx -o again.png --size 80x60 --tf solid " + camera).status, 0);
  EXPECT_EQ(shell("cmp '" + path("ball.png") + "' '" + path("again.png") + "'").status, 0);
}

TEST_F(Program, renders_a_foreign_file_as_its_store) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  ASSERT_EQ(gvx("render ball.gvx -o a.png --size 64x64").status, 0);
  ASSERT_EQ(gvx("render ball_40x36x30_uint8.raw -o b.png --size 64x64").status, 0);
  EXPECT_EQ(shell("cmp '" + path("a.png") + "' '" + path("b.png") + "'").status, 0);
}

TEST_F(Program, says_what_a_volume_lost) {
  std::ofstream nan(path("nan_4x4x4_float.raw"), std::ios::binary),
      wide(path("wide_4x4x4_double.raw"), std::ios::binary);
  for (int i = 0; i < 64; ++i) {
    const float with_gap = i == 21 ? NAN : static_cast<float>(-5 - i % 6);
    const double far = 1e9 + 0.5 * (i % 3);
    nan.write(reinterpret_cast<const char*>(&with_gap), sizeof(with_gap));
    wide.write(reinterpret_cast<const char*>(&far), sizeof(far));
  }
  nan.close(), wide.close();
  const std::string warning = "nan_4x4x4_float.raw: 1 voxels have no value (NaN): shown as transparent";
  EXPECT_NE(gvx("build nan_4x4x4_float.raw -o nan.gvx").output.find(warning), std::string::npos);
  EXPECT_NE(gvx("render nan_4x4x4_float.raw -o nan.png --size 8x8").output.find(warning), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(gvx("info nan.gvx --json").output)["value_range"],
            (std::vector<double>{-10, -5}));
  EXPECT_EQ(gvx("verify nan.gvx").status, 0);
  EXPECT_EQ(gvx("build wide_4x4x4_double.raw -o wide.gvx").output.find("rounded"), std::string::npos);
  EXPECT_NE(gvx("info wide.gvx").output.find("1000000000 to 1000000001\n"), std::string::npos);
}

TEST_F(Program, renders_the_sponge_and_writes_exr) {
  ASSERT_EQ(gvx("render sponge -o s.exr --size 64x48").status, 0);
  std::ifstream file(path("s.exr"), std::ios::binary);
  std::array<unsigned char, 4> magic{};
  file.read(reinterpret_cast<char*>(magic.data()), 4);
  EXPECT_EQ(magic, (std::array<unsigned char, 4>{0x76, 0x2f, 0x31, 0x01}));
}

/// A pyramid with a square base, closed.
void write_pyramid(const std::string& file) {
  std::ofstream(file) << "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                         "property float z\nelement face 5\nproperty list uchar int vertex_indices\n"
                         "end_header\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n1 1 1.5\n"
                         "4 3 2 1 0\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";
}

TEST_F(Program, renders_what_is_made) {
  std::vector<std::string> scenes = {"cloud", "terrain --octaves 4 --seed 7",
                                     "repeat:2:cloud --octaves 2 --levels 3"};
  write_pyramid(path("pyramid.ply"));
  const bool embree = gvx("render distance:pyramid.ply -o p.png --size 8x8 --levels 2").status == 0;
  if (embree) {
    for (const char* kind : {"cloud", "distance", "axis-distance", "hypertexture", "pseudo-mesh", "ramp",
                             "blurred", "solid-noise"}) {
      scenes.push_back(std::string(kind) + ":pyramid.ply --levels 4");
    }
    scenes.emplace_back("repeat:2:amplify:distance:pyramid.ply --levels 2");
    scenes.emplace_back("pyramid.ply --resolution 50");
  }
  for (const std::string& scene : scenes) {
    const Outcome outcome = gvx("render " + scene + " -o a.png --size 40x30 --detail 1 --transparent");
    ASSERT_EQ(outcome.status, 0) << scene << "\n" << outcome.output;
    const auto picture = io::read_png(path("a.png"));
    ASSERT_TRUE(picture.ok());
    int seen = 0;
    for (std::size_t i = 3; i < picture.value().rgba.size(); i += 4)
      seen += picture.value().rgba[i] > 20 ? 1 : 0;
    EXPECT_GT(seen, 40) << scene;
    EXPECT_LT(seen, 40 * 30) << scene;
  }
  expect_error("render sponge -o a.png --octaves 3", "octaves does not apply to this scene");
  expect_error("render cloud -o a.png --octaves 99", "octaves");
  expect_error("render repeat:3:cloud -o a.png", "power of 2");
  expect_error("render repeat:sponge -o a.png", "trees of 2");
  expect_error("render distance:none.ply -o a.png", "none.ply");
  expect_error("render amplify:none.gvx -o a.png", "none.gvx");
}

/// Decibels between the bytes of two pictures.
double decibels(const std::string& a, const std::string& b) {
  const auto one = io::read_png(a).value().rgba, other = io::read_png(b).value().rgba;
  GVX_CHECK(one.size() == other.size());
  double squares = 0;
  for (std::size_t i = 0; i < one.size(); ++i) squares += std::pow(double(one[i]) - double(other[i]), 2);
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(one.size()) / std::max(squares, 1e-9));
}

TEST_F(Program, shows_distances_in_the_march_as_densities_in_bricks) {
  write_pyramid(path("pyramid.ply"));
  if (gvx("render distance:pyramid.ply -o p.png --size 8x8 --levels 2").status != 0)
    GTEST_SKIP() << "no Embree";
  // A surface in bricks is as wide as their voxels, and farther from the same in the march.
  for (const auto& [kind, least] : std::vector<std::pair<std::string, double>>{
           {"hypertexture", 34}, {"pseudo-mesh", 28}, {"ramp", 50}, {"blurred", 31}}) {
    const std::string scene =
        "render " + kind + ":pyramid.ply --levels 6 --octaves 3 --size 120x90 --detail 1";
    const Outcome bricks = gvx(scene + " -o bricks.png"), march = gvx(scene + " --in-march -o march.png");
    ASSERT_EQ(bricks.status, 0) << bricks.output;
    ASSERT_EQ(march.status, 0) << march.output;
    const double found = decibels(path("bricks.png"), path("march.png"));
    std::printf("%s: %.1f dB\n", kind.c_str(), found);
    EXPECT_GE(found, least) << kind;
  }
  expect_error("render solid-noise:pyramid.ply --in-march -o a.png", "inMarch does not apply to this scene");
}

TEST_F(Program, builds_a_store_of_a_mesh) {
  write_pyramid(path("pyramid.ply"));
  const Outcome built = gvx("build pyramid.ply -o p.gvx --resolution 60");
  if (built.output.find("Embree") != std::string::npos) GTEST_SKIP() << built.output;
  ASSERT_EQ(built.status, 0) << built.output;
  EXPECT_NE(built.output.find("66 x 66 x 51 voxels"), std::string::npos) << built.output;
  EXPECT_EQ(gvx("verify p.gvx").status, 0);
  ASSERT_EQ(gvx("render p.gvx -o stored.png --size 50x40").status, 0);
  ASSERT_EQ(gvx("render pyramid.ply --resolution 60 -o direct.png --size 50x40").status, 0);
  EXPECT_EQ(shell("cmp " + path("stored.png") + " " + path("direct.png")).status, 0);
  // A scene file in another folder finds the mesh beside it.
  fs::create_directories(path("below"));
  fs::copy(path("pyramid.ply"), path("below/pyramid.ply"));
  std::ofstream(path("below/scene.json"))
      << R"({"volume": "distance:pyramid.ply", "generate": {"levels": 3}})";
  fs::remove(path("pyramid.ply"));
  const Outcome placed = gvx("render below/scene.json -o a.png --size 8x8");
  EXPECT_EQ(placed.status, 0) << placed.output;

  std::ofstream(path("open.ply"))
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0\n2 0 0\n2 2 0\n3 0 1 2\n";
  expect_error("build open.ply -o o.gvx --fill solid", "not closed");
  EXPECT_EQ(gvx("build open.ply -o o.gvx --resolution 20").status, 0);
  expect_error("build open.ply -o x.gvx --resolution 100000", "--memory");
  expect_error("build open.ply -o x.gvx --labels", "mesh");
  expect_error("build open.ply -o x.gvx --dims 3,3,3", "a mesh");
  const Outcome described = gvx("info open.ply --json");
  ASSERT_EQ(described.status, 0) << described.output;
  const auto json = nlohmann::json::parse(described.output);
  EXPECT_EQ(json["triangles"], 1);
  EXPECT_EQ(json["closed"], false);
  EXPECT_EQ(json["maximum"], (std::vector<double>{2, 2, 0}));
  EXPECT_NE(gvx("info open.ply").output.find("open"), std::string::npos);
  EXPECT_FALSE(fs::exists(path("x.gvx")));
  EXPECT_FALSE(fs::exists(path("x.gvx.partial")));
}

TEST_F(Program, the_picture_does_not_depend_on_memory_or_threads) {
  // A head CT where Debian's package is there, a ball otherwise.
  write_ball();
  std::string input = "ball_40x36x30_uint8.raw";
  if (shell(GVX_FETCH_HEAD " '" + folder() + "'").status == 0) input = "head.nhdr";
  ASSERT_EQ(gvx("build " + input + " -o v.gvx").status, 0);
  ASSERT_EQ(gvx("render v.gvx -o first.png --size 400x300").status, 0);
  for (const char* memory : {"4M", "32M", "1G"}) {
    for (const char* threads : {"1", "2"}) {
      const std::string flags = std::string(" --memory ") + memory + " --threads " + threads;
      ASSERT_EQ(gvx("render v.gvx -o other.png --size 400x300" + flags).status, 0);
      EXPECT_EQ(shell("cmp '" + path("first.png") + "' '" + path("other.png") + "'").status, 0) << flags;
    }
  }
}

TEST_F(Program, budget_frames_end_at_the_exact_picture) {
  write_ball();
  ASSERT_EQ(gvx("render ball_40x36x30_uint8.raw -o a.png --size 64x64 --exact").status, 0);
  ASSERT_EQ(gvx("render ball_40x36x30_uint8.raw -o b.png --size 64x64 --budget 20ms --budget-frames 300 "
                "--stats b.json")
                .status,
            0);
  EXPECT_EQ(read_json("b.json")["converged"], true);
  EXPECT_EQ(shell("cmp '" + path("a.png") + "' '" + path("b.png") + "'").status, 0);
}

/// The JSON examples of docs/scene-file.md, in their order.
std::vector<std::string> documented_scenes() {
  std::ifstream file(GVX_SOURCE_DIR "/docs/scene-file.md");
  std::vector<std::string> scenes;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("```")) {
      inside = line == "```json";
      if (inside) scenes.emplace_back();
    } else if (inside) {
      scenes.back() += line + "\n";
    }
  }
  return scenes;
}

TEST_F(Program, renders_the_scene_files_of_the_documentation) {
  write_ball();
  fs::create_directories(path("scenes"));
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o scenes/head.gvx").status, 0);
  const auto scenes = documented_scenes();
  ASSERT_EQ(scenes.size(), 3u);
  std::ofstream(path("scenes/still.json")) << scenes[0];
  std::ofstream(path("scenes/tour.json")) << scenes[1];
  std::ofstream(path("scenes/objects.json")) << scenes[2];
  Outcome outcome = gvx("render scenes/objects.json -o objects.png --save-scene saved.json");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  outcome = gvx("render saved.json -o again.png");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(io::read_png(path("objects.png")).value().rgba, io::read_png(path("again.png")).value().rgba);
  expect_error("render scenes/objects.json -o no.png --proxy nodes",
               "--proxy: goes with a scene of one object without a transform");
  outcome = gvx("render scenes/still.json -o still.png");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  const auto image = io::read_png(path("still.png")).value();
  EXPECT_EQ(image.width, 640u);
  EXPECT_GT(image.rgba[4 * (640 * 240 + 320)], 100);  // the ball is in the middle
  EXPECT_NEAR(image.rgba[2], 0.08 * 255, 1);
  outcome = gvx("render scenes/tour.json -o tour.png --frames 1-4");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 4) << outcome.output;
  for (const char* name : {"tour.0001.png", "tour.0002.png", "tour.0003.png", "tour.0004.png"}) {
    EXPECT_EQ(io::read_png(path(name)).value().width, 64u) << name;
  }
  EXPECT_NE(shell("cmp '" + path("tour.0001.png") + "' '" + path("tour.0002.png") + "'").status, 0);
}

TEST_F(Program, a_saved_scene_gives_the_same_picture_and_flags_override_it) {
  write_ball();
  fs::create_directories(path("elsewhere/deep"));
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  std::ofstream(path("map.json"))
      << R"([{"RGBPoints": [0, 0, 0, 1, 250, 1, 0, 0], "Points": [0, 0, 0.5, 0, 250, 1, 0.5, 0]}])";
  const std::string saved = "elsewhere/deep/scene.json";
  const std::string flags[] = {
      "",
      "--antialias 2 --tf map.json --gradient-opacity 0,0,20,1 --light directional:0,-1,1:1,0.5,0.2 "
      "--light camera:0,0,1 --ambient 0.1 --diffuse 0.8 --specular 0.4 --shininess 10",
      "--mode maximum --camera 'fov=20' --background 0.1,0.2,0.3 --finest --samples 3",
      "--classification post --tf map.json",
      "--mode isosurface --isovalue 120 --transparent --clip 0,0,0,0.5,1,1",
      "--flat --tf solid --camera 'height=60'",
      "--key-frame '0:eye=0,-90,20' --key-frame '10:eye=90,0,20'"};
  for (const std::string& flag : flags) {
    Outcome outcome = gvx("render ball.gvx -o a.png --size 64x48 " + flag + " --save-scene " + saved);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    outcome = gvx("render " + saved + " -o b.png --save-scene elsewhere/again.json");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_EQ(shell("cmp '" + path("a.png") + "' '" + path("b.png") + "'").status, 0) << flag;
    auto before = read_json(saved), after = read_json("elsewhere/again.json");
    EXPECT_EQ(before["volume"], "../../ball.gvx");
    EXPECT_EQ(after["volume"], "../ball.gvx");
    for (auto* scene : {&before, &after}) {
      scene->erase("volume");
      scene->erase("functions");
    }
    EXPECT_EQ(before, after) << flag;
  }
  ASSERT_EQ(gvx("render " + saved + " -o c.png --size 32x16 --mode mean --shaded").status, 0);
  EXPECT_EQ(io::read_png(path("c.png")).value().width, 32u);
  ASSERT_EQ(
      gvx("render ball_40x36x30_uint8.raw -o raw.png --size 32x32 --spacing 1,1,2 --save-scene raw.json")
          .status,
      0);
  EXPECT_EQ(read_json("raw.json")["raw"]["spacing"], (std::vector<double>{1, 1, 2}));
  ASSERT_EQ(gvx("render raw.json -o raw2.png").status, 0);
  EXPECT_EQ(shell("cmp '" + path("raw.png") + "' '" + path("raw2.png") + "'").status, 0);
}

TEST_F(Program, frames_go_around_the_target_and_finished_ones_stay) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  const std::string size = "render ball.gvx --size 48x48 --tf solid ";
  ASSERT_EQ(gvx(size + "-o still.png").status, 0);
  Outcome outcome = gvx(size + "-o 'turn_%02d.png' --frames 3 --quiet --stats s.json");
  ASSERT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(outcome.output, "");
  EXPECT_EQ(read_json("s.json")["converged"], true);
  EXPECT_EQ(shell("cmp '" + path("still.png") + "' '" + path("turn_01.png") + "'").status, 0);
  EXPECT_TRUE(fs::exists(path("turn_03.png")));
  EXPECT_FALSE(fs::exists(path("turn_04.png")));
  // A folder where the second picture is to be.
  fs::create_directories(path("stop.0002.png/in_the_way"));
  outcome = gvx(size + "-o stop.png --frames 3 --quiet");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.output.rfind("gvx: frame 2: ", 0), 0u) << outcome.output;
  EXPECT_TRUE(fs::exists(path("stop.0001.png")));
  EXPECT_FALSE(fs::exists(path("stop.0003.png")));
}

TEST_F(Program, bad_scenes_are_one_line_that_names_the_field) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  const auto expect_scene_error = [&](const std::string& text, const std::string& part) {
    std::ofstream(path("s.json")) << text;
    expect_error("render s.json -o a.png", part);
  };
  expect_scene_error("{", "s.json: not JSON at line 1, column 2");
  expect_scene_error("{}", "s.json: the scene names no volume");
  expect_scene_error(R"({"volume": "ball.gvx", "colour": 1})", "s.json: expected fields among");
  expect_scene_error(R"({"volume": "none.gvx"})", "none.gvx: cannot open");
  expect_scene_error(R"({"volume": "ball.gvx", "mode": "isosurface"})",
                     "isovalue: mode isosurface needs one");
  expect_scene_error(R"({"volume": "ball.gvx", "functions": ["gray", "gray"]})",
                     "2 transfer functions for a volume that takes 1");
  expect_scene_error(R"({"volume": "ball.gvx", "function": "rainbow"})", "rainbow");
  expect_scene_error(R"({"volume": "ball.gvx", "camera": {"up": [0, 0, 0]}})", "up");
  expect_scene_error(R"({"volume": "ball.gvx", "cameraPath": [{"frame": 2}, {"frame": 1}]})", "key frame 2");
  expect_scene_error(
      R"({"volume": "ball.gvx", "cameraPath": [{"frame": 1, "fov": 9}, {"frame": 2, "height": 9}]})",
      "key frame 2");
  expect_error("render s.json --volume ball.gvx -o a.png --antialias 9", "--antialias: expected");
  expect_error("render missing.json -o a.png", "missing.json: cannot open");
  expect_error("render ball.gvx -o a.png --volume ball.gvx", "--volume");
  expect_error("render ball.gvx -o a.png --isovalue 5", "--isovalue");
  expect_error("render ball.gvx -o a.png --mode isosurface", "from 0");
  expect_error("render ball.gvx -o a.png --light sun:1,2,3", "sun");
  expect_error("render ball.gvx -o a.png --light point:1,2", "1,2");
  expect_error("render ball.gvx -o a.png --ambient nan", "--ambient: ");
  expect_error("render ball.gvx -o a.png --gradient-opacity 1,2,3", "--gradient-opacity");
  expect_error("render ball.gvx -o a.png --gradient-opacity 0,2", "gradient point 1");
  expect_error("render ball.gvx -o a.png --mode maximum --gradient-opacity 0,1", "only mode composite");
  expect_error("render ball.gvx -o a.png --mode maximum --classification post", "classification");
  expect_error("render ball.gvx -o a.png --key-frame eye=1,2,3", "--key-frame");
  expect_error("render ball.gvx -o a.png --frames 5-2", "--frames");
  expect_error("render ball.gvx -o a.png --frames 0", "--frames");
  expect_error("render ball.gvx -o a.png --save-scene no/such/s.json", "no/such");
  EXPECT_FALSE(fs::exists(path("a.png")));
}

TEST_F(Program, bad_command_lines_are_one_line_and_status_2) {
  for (const char* arguments :
       {"", "explode", "render", "render sponge", "build x.raw", "build x.raw -o y.gvx --brick 12",
        "build x.raw -o y.gvx --codec zip", "render sponge -o a.png --device abacus",
        "render sponge -o a.png --threads -3", "render sponge -o a.png --exact --budget 5ms",
        "render sponge -o a.png --frames 3 --budget 5ms", "render sponge -o a.png --budget-frames 3",
        "render sponge -o a.png --mode xray", "render sponge -o a.png --classification best",
        "render sponge -o a.png --ambient much", "info"}) {
    const Outcome outcome = gvx(arguments);
    EXPECT_EQ(outcome.status, 2) << arguments << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  }
}

TEST_F(Program, bad_values_are_one_line_that_names_them) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  expect_error("render ball.gvx -o a.jpg", "a.jpg");
  expect_error("render ball.gvx -o a.png --size 12", "'12'");
  expect_error("render ball.gvx -o a.png --size 99999x5", "99999");
  expect_error("render ball.gvx -o a.png --camera eye=1,2", "camera");
  expect_error("render ball.gvx -o a.png --memory lots", "lots");
  expect_error("render ball.gvx -o a.png --memory 100", "memory");
  expect_error("render ball.gvx -o a.png --budget soon", "soon");
  expect_error("render ball.gvx -o a.png --tf rainbow", "rainbow");
  expect_error("render ball.gvx -o a.png --clip 1,1,1,0,0,0", "clip");
  expect_error("render ball.gvx -o no/such/folder/a.png", "no/such/folder");
  expect_error("render nothing.gvx -o a.png", "nothing.gvx");
  expect_error("render ball.gvx -o a.png --stats no/such/s.json", "no/such");
  expect_error("build ball_40x36x30_uint8.raw -o ball.gvx", "--force");
  expect_error("build ball_40x36x30_uint8.raw -o no/such/b.gvx", "no/such");
  expect_error("build ball_40x36x30_uint8.raw -o b.gvx --dims 4,4,400000 --dtype f64",
               "ball_40x36x30_uint8.raw");
  expect_error("build ball_40x36x30_uint8.raw -o b.gvx --dims 0,4,4", "0,4,4");
  expect_error("build ball_40x36x30_uint8.raw -o b.gvx --dtype u128", "u128");
  expect_error("build ball_40x36x30_uint8.raw -o b.gvx --memory 10K", "--memory");
  expect_error("verify ball_40x36x30_uint8.raw", "ball_40x36x30_uint8.raw");
  expect_error("info .", ".");
  EXPECT_FALSE(fs::exists(path("a.png")) && fs::file_size(path("a.png")) == 0);
  EXPECT_FALSE(fs::exists(path("b.gvx")));
}

TEST_F(Program, asking_for_a_gpu_that_is_not_there_is_an_error) {
  if (shell("nvidia-smi").status == 0) GTEST_SKIP() << "there is a GPU";
  expect_error("render sponge -o a.png --device cuda", "CUDA");
}

TEST_F(Program, a_damaged_store_is_an_error_and_leaves_no_picture) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  std::fstream file(path("ball.gvx"), std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(700);
  for (int i = 0; i < 3000; ++i) file.put('#');
  file.close();
  expect_error("render ball.gvx -o a.png", "ball.gvx: corrupt");
  expect_error("verify ball.gvx", "ball.gvx: corrupt");
  EXPECT_FALSE(fs::exists(path("a.png")));
}

TEST_F(Program, a_store_of_a_newer_version_is_an_error_that_says_so) {
  write_ball();
  ASSERT_EQ(gvx("build ball_40x36x30_uint8.raw -o ball.gvx").status, 0);
  std::fstream file(path("ball.gvx"), std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(8);
  file.put(4);
  file.close();
  for (const char* command : {"render ball.gvx -o a.png", "info ball.gvx", "verify ball.gvx"}) {
    expect_error(command, "ball.gvx: made by a newer gvx: version 4; this program reads up to 3");
  }
}

TEST_F(Program, a_build_that_is_killed_leaves_no_store_and_the_next_one_works) {
  // A pipe that stays open in the middle of the volume: the build waits for the rest when it is killed.
  const std::string flags = "build - -o killed.gvx --dims 512,512,400 --dtype u8";
  const Outcome killed =
      shell("cd '" + folder() +
            "' && { head -c 20000000 /dev/zero; sleep 3; } | timeout -s KILL 1.5 " GVX_PROGRAM " " + flags +
            "; true");
  EXPECT_EQ(killed.output.find("voxels"), std::string::npos);
  EXPECT_TRUE(fs::exists(path("killed.gvx.partial")));
  EXPECT_FALSE(fs::exists(path("killed.gvx")));
  EXPECT_EQ(gvx("verify killed.gvx.partial").status, 1);
  const Outcome outcome =
      shell("cd '" + folder() + "' && head -c 104857600 /dev/zero | " GVX_PROGRAM " " + flags);
  EXPECT_EQ(outcome.status, 0) << outcome.output;
  EXPECT_EQ(gvx("verify killed.gvx").status, 0);
  EXPECT_FALSE(fs::exists(path("killed.gvx.partial")));
}

TEST_F(Program, every_malformed_volume_gives_an_error_or_a_picture) {
  const char* data = std::getenv("GVX_TEST_DATA");
  if (data == nullptr || !fs::exists(std::string(data) + "/malformed"))
    GTEST_SKIP() << "GVX_TEST_DATA is not set";
  int tried = 0, rendered = 0;
  for (const auto& entry : fs::recursive_directory_iterator(std::string(data) + "/malformed")) {
    if (!entry.is_regular_file()) continue;
    const std::string extension = entry.path().extension();
    const bool volume = extension == ".nrrd" || extension == ".nhdr" || extension == ".gz" ||
                        extension == ".raw" || extension == ".nii" || extension == ".mha" ||
                        extension == ".mhd";
    // Every volume, and a sample of the rest: what is no volume at all must be refused as clearly.
    if (!volume && tried % 5 != 0) {
      ++tried;
      continue;
    }
    ++tried;
    // Of meshes the reader is what is tested here.
    const bool mesh = extension == ".ply" || extension == ".obj" || extension == ".stl" ||
                      extension == ".gltf" || extension == ".glb";
    const Outcome outcome = gvx("render '" + entry.path().string() + "' -o m.png --size 32x32 --quiet" +
                                (mesh ? " --resolution 40" : ""));
    EXPECT_TRUE(outcome.status == 0 || outcome.status == 1)
        << entry.path() << outcome.status << outcome.output;
    EXPECT_LE(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    if (outcome.status == 1) {
      EXPECT_EQ(outcome.output.rfind("gvx: ", 0), 0u) << outcome.output;
    }
    rendered += outcome.status == 0 ? 1 : 0;
  }
  EXPECT_GT(tried, 100);
  EXPECT_GT(rendered, 3);
}

/// A cube as text, each of whose faces is there so many times.
std::string cube_ply(double x, double y, double z, double size, int times) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double "
      "z\nelement face " +
      std::to_string(6 * times) + "\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) {
    std::array<char, 200> line;
    std::snprintf(line.data(), line.size(), "%.17g %.17g %.17g\n", x + (i & 1) * size,
                  y + (i >> 1 & 1) * size, z + (i >> 2) * size);
    text += line.data();
  }
  for (int i = 0; i < times; ++i)
    text += "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";
  return text;
}

TEST_F(Program, a_cube_that_is_there_twice_far_from_0_is_seen) {
  std::ofstream(path("cube.ply")) << cube_ply(500000.125, 5400000.375, 312.5, 0.1, 2);
  const Outcome described = gvx("info cube.ply --json");
  ASSERT_EQ(described.status, 0) << described.output;
  const auto json = nlohmann::json::parse(described.output);
  EXPECT_EQ(json["minimum"], (std::vector<double>{500000.125, 5400000.375, 312.5}));
  EXPECT_EQ(json["maximum"], (std::vector<double>{500000.125 + 0.1, 5400000.375 + 0.1, 312.5 + 0.1}));
  EXPECT_EQ(json["closed"], true);
  EXPECT_EQ(json["triangles"], 24);
  const Outcome built = gvx("build cube.ply -o cube.gvx --resolution 32 --fill solid");
  if (built.output.find("Embree") != std::string::npos) GTEST_SKIP() << built.output;
  ASSERT_EQ(built.status, 0) << built.output;
  for (const char* scene : {"cube.gvx", "cube.ply --resolution 32", "distance:cube.ply --levels 3"}) {
    const Outcome outcome = gvx("render " + std::string(scene) + " -o cube.png --size 32x32 --transparent");
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const io::Image image = io::read_png(path("cube.png")).value();
    std::size_t seen = 0;
    for (std::size_t p = 3; p < image.rgba.size(); p += 4) seen += image.rgba[p] > 127 ? 1 : 0;
    EXPECT_GT(seen, 100u) << scene;
    EXPECT_LT(seen, 1000u) << scene;
  }
}

TEST_F(Program, says_in_one_line_what_of_a_mesh_it_leaves_out) {
  std::ofstream(path("cube.obj"))
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nvt 0 0\n"
         "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
         "f 2 4 8\nf 1 1 2\nl 1 2\n";
  const Outcome built = gvx("build cube.obj -o cube.gvx --resolution 20");
  if (built.output.find("Embree") != std::string::npos) GTEST_SKIP() << built.output;
  ASSERT_EQ(built.status, 0) << built.output;
  EXPECT_NE(
      built.output.find("gvx: cube.obj: 1 triangle covers nothing; left out; 1 triangle is there twice; "
                        "counted once; not used: texture coordinates, lines\n"),
      std::string::npos)
      << built.output;
  // One face is turned: still solid, and said.
  std::ofstream(path("turned.obj"))
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3\n";
  const Outcome turned = gvx("build turned.obj -o turned.gvx --resolution 20 --fill solid");
  EXPECT_EQ(turned.status, 0) << turned.output;
  EXPECT_NE(turned.output.find("not wound alike"), std::string::npos) << turned.output;
}

TEST_F(Program, a_mesh_of_nothing_is_an_error_that_leaves_nothing) {
  std::ofstream(path("points.obj")) << "v 0 0 0\nv 1 0 0\np 1 2\n";
  std::ofstream(path("flat.obj")) << "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
  std::ofstream(path("nan.obj")) << "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n";
  std::ofstream(path("empty.stl")) << "solid nothing\nendsolid\n";
  std::ofstream(path("needs.gltf"))
      << R"({"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_draco_mesh_compression"],
                                          "extensionsRequired": ["KHR_draco_mesh_compression"]})";
  for (const auto& [name, part] : {std::pair{"points.obj", "no triangle in it; not used: points"},
                                   {"flat.obj", "without an area"},
                                   {"nan.obj", "not finite"},
                                   {"empty.stl", "no triangle"},
                                   {"needs.gltf", "KHR_draco_mesh_compression"}}) {
    const std::string mesh = name;
    expect_error("build " + mesh + " -o out.gvx", part);
    expect_error("render " + mesh + " -o out.png --size 8x8", part);
    expect_error("info " + mesh, part);
    expect_error("render distance:" + mesh + " -o out.png --size 8x8", mesh);
  }
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder())) files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, 5u);
}

TEST_F(Program, meshes_of_the_field_are_what_they_should_be) {
  const char* data = std::getenv("GVX_TEST_DATA");
  if (data == nullptr || !fs::exists(std::string(data) + "/field"))
    GTEST_SKIP() << "GVX_TEST_DATA has no field cases";
  struct Case {
    const char* name;
    int triangles;
    bool closed;
    std::vector<double> maximum;
  };
  for (const Case& c :
       {Case{"field/mesh-pasted-twice/s05_duplicate_faces.ply", 24, true, {1, 1, 1}},
        Case{"field/mesh-pasted-twice/t05b_pasted_twice.ply", 24, true, {1, 1, 1}},
        Case{"field/mesh-pasted-twice/t05f_one_face_twice.ply", 12, true, {1, 1, 1}},
        Case{"field/mesh-closed-by-slivers/s06_sliver_closed.ply", 13, true, {1, 1, 1}},
        Case{"meshes/trimesh/wallhole.obj", 66, true, {10, 15, 0}},
        Case{"field/mesh-overlapping-parts/s07_overlapping_spheres.ply", 4416, true, {}},
        Case{"field/mesh-georeferenced/s02b_utm_ascii_small.ply", 12, true, {500000.225, 5400000.475, 312.6}},
        Case{"field/mesh-georeferenced/s02_utm_double.ply", 12, true, {500002.125, 5400002.375, 314.5}},
        Case{"field/mesh-concave-polygon/s03_concave_L.ply", 20, true, {3, 3, 1}},
        Case{"field/mesh-concave-polygon/t03_open_U_polygon.ply", 6, false, {3, 3, 0}},
        Case{"field/gltf-quantized/t15_quantized_no_scale.gltf", 12, true, {16000, 16000, 16000}},
        Case{"field/gltf-vertex-colours/s15e_colors_half_linear.gltf", 12, true, {1, 1, 1}},
        Case{"field/ply-line-ends/s08c_cr_only.ply", 12, true, {1, 1, 1}}}) {
    const Outcome described = gvx("info '" + std::string(data) + "/" + c.name + "' --json");
    ASSERT_EQ(described.status, 0) << described.output;
    const auto json = nlohmann::json::parse(described.output);
    EXPECT_EQ(json["triangles"], c.triangles) << c.name;
    EXPECT_EQ(json["closed"], c.closed) << c.name;
    if (!c.maximum.empty()) {
      EXPECT_EQ(json["maximum"], c.maximum) << c.name;
    }
  }
}

}  // namespace
}  // namespace gvx
